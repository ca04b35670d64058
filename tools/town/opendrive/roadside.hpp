// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "town/opendrive/drive.hpp"
#include "town/opendrive/terrain.hpp"
#include "town/plan.hpp"

namespace gnosphere::town::opendrive {

/// Places objects along the roads of a network; only vehicles stand on a road.
class Roadside {
 public:
  Roadside(Plan& plan, const Network& network, const Terrain& terrain, const Area& land, const Drive& drive,
           const Detail& detail)
      : plan_(plan),
        terrain_(terrain),
        land_(land),
        drive_(drive),
        detail_(detail),
        focus_(drive.points.front().at),
        occupancy_(network, land) {}

  void addGround(std::vector<GroundPiece> pieces, bool areRoads);
  void build(const Road& road, bool left, Dice& dice);    ///< houses on one side
  void furnish(const Road& road, bool left, Dice& dice);  ///< sidewalks: lamps, trees, signs, people
  void addTraffic(const Road& road, Dice& dice);          ///< driving and parking vehicles
  void plant(Dice& dice);                                 ///< trees on free ground

 private:
  struct Spot;
  Spot edgeOf(const Road& road, bool left, double s) const;
  bool sidewalkOf(const Road& road, bool left, double s, Spot& spot) const;
  void put(const Thing& thing, const Transform& where);
  void addSmallThing(const Spot& spot, Dice& dice);
  void addGarden(const Spot& spot, double width, Dice& dice);
  bool addBuilding(const Spot& spot, const Building& building, double setback);

  Plan& plan_;
  const Terrain& terrain_;
  Area land_;
  const Drive& drive_;
  const Detail& detail_;
  Vec3 focus_;
  Occupancy occupancy_;
};

}  // namespace gnosphere::town::opendrive
