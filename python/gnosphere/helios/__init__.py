# SPDX-License-Identifier: Apache-2.0
"""Surveys of HELIOS++ as drives: docs/surveys.md.

    survey = gnosphere.helios.read_survey("helios/data/surveys/toyblocks/als_toyblocks.xml")
    files = survey.write("out")        # out/leg-000.json and so on, for `gnosphere drive`

`python -m gnosphere.helios SURVEY -o FOLDER` does the same.
"""

from .survey import Leg as Leg, Survey as Survey, read_survey as read_survey
