// SPDX-License-Identifier: Apache-2.0
// Fills a block: rows of houses, gardens, offices, a market, a park.
#include <algorithm>
#include <cmath>

#include "town/choice.hpp"

namespace gnosphere::town {
namespace {

enum class Use : uint8_t { terrace, gardens, offices, market, park, church };

Use useOf(const Site& site, Dice& dice) {
  if (site.row == 0 && site.column == 0) return Use::terrace;
  if (site.row == 0 && site.column == -1) return Use::gardens;
  if (site.row == -1 && site.column == 0) return Use::offices;
  if (site.row == -1 && site.column == -1) return Use::terrace;
  if (site.row == 0 && site.column == 1) return Use::church;
  const int pick = dice.below(100);
  if (pick < 42) return Use::terrace;
  if (pick < 70) return Use::gardens;
  if (pick < 82) return Use::offices;
  if (pick < 88) return Use::market;
  return pick < 98 ? Use::park : Use::church;
}

/// The land of a block inside its sidewalks, and the objects placed on it.
class Land {
 public:
  Land(Plan& plan, const Site& site, const Detail& detail, Dice& dice)
      : plan_(plan),
        detail_(detail),
        dice_(dice),
        x0(site.x0 + kSidewalk),
        y0(site.y0 + kSidewalk),
        x1(site.x1 - kSidewalk),
        y1(site.y1 - kSidewalk) {}

  void terrace();
  void gardens();
  void offices();
  void market();
  void park(bool church);

 private:
  void put(const Thing& thing, double x, double y, double turns = 0, double scale = 1) {
    plan_.add(thing, {x, y, kKerbHeight}, turns, scale);
  }
  void tree(double x, double y);
  void bush(double x, double y);
  void row(double from, double to, int side, int depth, bool corners);
  void garden(double from, double to, int side, double depth);
  void carPark(double left, double low, double right, double high);
  /// Returns the point at a distance along a side (0 = south, counter-clockwise) and a distance inwards.
  Vec3 onSide(int side, double along, double inward) const;
  double lengthOf(int side) const { return side % 2 == 0 ? x1 - x0 : y1 - y0; }

  Plan& plan_;
  const Detail& detail_;
  Dice& dice_;
  double x0, y0, x1, y1;
};

Vec3 Land::onSide(int side, double along, double inward) const {
  switch (side) {
    case 0: return {x0 + along, y0 + inward, 0};
    case 1: return {x1 - inward, y0 + along, 0};
    case 2: return {x1 - along, y1 - inward, 0};
    default: return {x0 + inward, y1 - along, 0};
  }
}

void Land::tree(double x, double y) {
  const Tree tree = anyTree(dice_, detail_);
  const double turns = dice_.uniform(), size = dice_.between(0.75, 1.3);
  put(tree, x, y, turns, size);
}

void Land::bush(double x, double y) {
  const int variant = dice_.below(4);
  const double turns = dice_.uniform(), size = dice_.between(0.7, 1.3);
  put(Tree{TreeKind::bush, detail_.treeLeaves / 4, variant}, x, y, turns, size);
}

void Land::row(double from, double to, int side, int depth, bool corners) {
  double along = from;
  bool first = true;
  while (to - along >= 8) {
    int width = anyRowWidth(dice_);
    while (width > to - along) width -= 2;
    const bool last = to - along - width < 8;
    const Building building = anyRowBuilding(dice_, width, depth, corners && (first || last));
    // The last house ends with the row; the remaining gap becomes a passage before it.
    const double start = last ? to - width : along;
    const int passage = static_cast<int>(start - along);
    if (passage >= 2 && !first) {
      const Vec3 at = onSide(side, along + (start - along - passage) / 2, 0.4);
      put(Prop{PropKind::fence, 0, passage}, at.x, at.y, 0.25 * side);
    }
    const Vec3 at = onSide(side, start + width / 2.0, 0);
    put(building, at.x, at.y, 0.25 * side);
    along = start + width;
    first = false;
  }
}

void Land::terrace() {
  const int depth = 10 + dice_.below(3);
  const double width = x1 - x0, height = y1 - y0;
  row(0, width, 0, depth, true);
  row(depth + 0.0, height - depth, 1, depth, false);
  row(0, width, 2, depth, true);
  row(depth + 0.0, height - depth, 3, depth, false);
  const double margin = depth + 3.5;
  const int count = static_cast<int>((width - 2 * margin) * (height - 2 * margin) / 130);
  for (int i = 0; i < count; ++i) {
    const double x = dice_.between(x0 + margin, x1 - margin), y = dice_.between(y0 + margin, y1 - margin);
    if (dice_.chance(60))
      tree(x, y);
    else
      bush(x, y);
  }
}

/// Places one garden with its house, `depth` metres deep from the street.
void Land::garden(double from, double to, int side, double depth) {
  const Building house = anyHouse(dice_);
  const double turns = 0.25 * side, middle = from + 0.7 + house.width / 2.0;
  const double setback = dice_.between(4.5, 6.5);
  const Vec3 at = onSide(side, middle, setback);
  put(house, at.x, at.y, turns);
  const int run = static_cast<int>(to - from) - 4;
  const Vec3 fence = onSide(side, from + 0.2, 0.5);
  put(Prop{dice_.chance(50) ? PropKind::hedge : PropKind::fence, 0, run}, fence.x, fence.y, turns);
  const Vec3 border = onSide(side, to - 0.3, 0.8);
  put(Prop{PropKind::fence, 0, static_cast<int>(depth) - 2}, border.x, border.y, turns + 0.25);
  if (dice_.chance(60)) {
    const Vec3 drive = onSide(side, to - 2.0, setback + 0.5);
    put(Vehicle{dice_.chance(50) ? VehicleKind::estate : VehicleKind::hatchback,
                dice_.chance(50) ? Surface::paintRed : Surface::paintSilver, detail_.fine},
        drive.x, drive.y, turns - 0.25);
  }
  const Vec3 back = onSide(side, dice_.between(from + 2, to - 2), depth - 3.0);
  tree(back.x, back.y);
  for (int i = 0; i < 3; ++i) {
    const double along = dice_.between(from + 1, to - 5), inward = dice_.between(1.4, setback - 1.2);
    const Vec3 spot = onSide(side, along, inward);
    bush(spot.x, spot.y);
  }
}

void Land::gardens() {
  for (int side : {0, 2}) {
    const double length = lengthOf(side), depth = std::min(24.0, (y1 - y0) / 2 - 1);
    const int count = static_cast<int>(length / 15.5);
    for (int i = 0; i < count; ++i) garden(length * i / count, length * (i + 1) / count, side, depth);
  }
  const double middle = (y0 + y1) / 2;
  for (double x = x0 + 4; x < x1 - 3; x += dice_.between(6, 12)) {
    const double y = middle + dice_.between(-3, 3);
    tree(x, y);
  }
}

void Land::carPark(double left, double low, double right, double high) {
  constexpr Surface kPaints[] = {Surface::paintWhite, Surface::paintSilver, Surface::paintBlack, Surface::paintRed,
                                 Surface::paintBlue};
  constexpr VehicleKind kKinds[] = {VehicleKind::hatchback, VehicleKind::saloon, VehicleKind::estate};
  bool up = true;
  for (double y = low + 3; y < high - 2.5; y += up ? 5.4 : 11.0, up = !up)
    for (double x = left + 1.6; x < right - 1.4; x += 2.7) {
      const VehicleKind kind = kKinds[dice_.below(3)];
      const Surface paint = kPaints[dice_.below(5)];
      const double skew = dice_.between(-0.01, 0.01);
      if (dice_.chance(35)) put(Vehicle{kind, paint, detail_.fine}, x, y, (up ? 0.25 : 0.75) + skew);
    }
}

void Land::offices() {
  for (int side : {0, 2}) {
    const double length = lengthOf(side);
    double along = 0;
    while (length - along >= 18) {
      Building office;
      office.kind = BuildingKind::office;
      office.width = std::min(18 + 2 * dice_.below(5), static_cast<int>(length - along));
      office.depth = 15;
      office.floors = 3 + dice_.below(6);
      office.wall = dice_.chance(60) ? Surface::concrete : Surface::plasterWhite;
      office.style = dice_.below(6);
      const Vec3 at = onSide(side, along + office.width / 2.0, 1);
      put(office, at.x, at.y, 0.25 * side);
      along += office.width + 7;
    }
  }
  carPark(x0 + 3, y0 + 18, x1 - 3, y1 - 18);
  for (double y = y0 + 19; y < y1 - 18; y += 8) {
    tree(x0 + 1.5, y);
    tree(x1 - 1.5, y);
  }
}

void Land::market() {
  Building hall;
  hall.kind = BuildingKind::hall;
  hall.width = std::min(40, static_cast<int>(x1 - x0) - 8);
  hall.depth = 22;
  hall.floors = 1;
  hall.roof = dice_.chance(50) ? RoofKind::gable : RoofKind::flat;
  hall.wall = dice_.chance(50) ? Surface::concrete : Surface::brick;
  hall.cover = Surface::roofSlate;
  hall.style = dice_.below(6);
  put(hall, (x0 + x1) / 2, y1 - 2 - hall.depth);  // its front faces the cars
  carPark(x0 + 3, y0 + 3, x1 - 3, y1 - hall.depth - 6);
  for (double x = x0 + 3; x < x1 - 2; x += 10) tree(x, y0 + 1.2);
}

void Land::park(bool church) {
  const double midX = (x0 + x1) / 2, midY = (y0 + y1) / 2;
  if (church) {
    Building nave;
    nave.kind = BuildingKind::church;
    nave.width = 24;
    nave.depth = 12;
    nave.floors = 1;
    nave.roof = RoofKind::gable;
    nave.wall = dice_.chance(50) ? Surface::brick : Surface::plasterWhite;
    nave.cover = Surface::roofSlate;
    put(nave, midX + 2, midY - 6);
  } else {
    put(Prop{PropKind::kiosk}, midX, midY);
    for (int i = 0; i < 8; ++i)
      put(Prop{PropKind::bench}, midX + 6 * cosine(0.125 * i), midY + 6 * sine(0.125 * i), 0.125 * i + 0.5);
  }
  constexpr double kStep = 7.5;
  for (double x = x0 + 3; x < x1 - 2; x += kStep)
    for (double y = y0 + 3; y < y1 - 2; y += kStep) {
      const double px = x + dice_.between(-2, 2), py = y + dice_.between(-2, 2);
      const bool isFree = std::abs(px - midX) > (church ? 20 : 9) || std::abs(py - midY) > (church ? 10 : 9);
      if (!isFree || std::abs(px - midX) < 1.8 || std::abs(py - midY) < 1.8) continue;
      if (dice_.chance(62))
        tree(px, py);
      else if (dice_.chance(60))
        bush(px, py);
    }
  for (int i = 0; i < 6; ++i) {
    const double x = dice_.between(x0 + 2, x1 - 2), turns = dice_.uniform();
    put(Prop{PropKind::person, dice_.below(12), 0, detail_.fine}, x, midY + (church ? 9.5 : 1.2), turns);
  }
}

}  // namespace

void planBlock(Plan& plan, const Site& site, const Detail& detail) {
  Dice dice(site.seed, 8, static_cast<uint64_t>(site.column + 4096), static_cast<uint64_t>(site.row + 4096));
  const Use use = useOf(site, dice);
  const Surface inside = use == Use::offices || use == Use::market ? Surface::paving : Surface::grass;
  const auto centimetres = [](double metres) { return static_cast<int>(std::lround(100 * metres)); };
  const Block block = {centimetres(site.x1 - site.x0), centimetres(site.y1 - site.y0), centimetres(kSidewalk), inside};
  plan.addGround(block, {site.x0, site.y0, 0}, 0, {site.x0, site.y0, 0}, {site.x1, site.y1, 0});
  Land land(plan, site, detail, dice);
  switch (use) {
    case Use::terrace: land.terrace(); break;
    case Use::gardens: land.gardens(); break;
    case Use::offices: land.offices(); break;
    case Use::market: land.market(); break;
    case Use::park: land.park(false); break;
    case Use::church: land.park(true); break;
  }
}

}  // namespace gnosphere::town
