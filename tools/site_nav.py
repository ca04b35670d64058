# SPDX-License-Identifier: Apache-2.0
"""A hook of MkDocs: in the navigation, FOLDER/* stands for the pages of the folder that its list does not name."""

from pathlib import Path


def with_folders(entries, pages):
    for entry in entries:
        if isinstance(entry, dict):
            yield {name: list(with_folders(of, pages)) if isinstance(of, list) else of for name, of in entry.items()}
        elif entry.endswith("/*"):
            found = sorted(path.relative_to(pages).as_posix() for path in (pages / entry[:-2]).glob("*.md"))
            yield from (page for page in found if page not in entries)
        else:
            yield entry


def on_config(config):
    config["nav"] = list(with_folders(config["nav"], Path(config["docs_dir"])))
    return config
