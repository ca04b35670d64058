// SPDX-License-Identifier: Apache-2.0
#include "town/facade.hpp"

namespace gnosphere::town {
namespace {

struct Filling {
  Surface surface;
  double depth;
};

Filling fillingOf(Opening opening, Surface wall) {
  switch (opening) {
    case Opening::window: return {Surface::windowGlass, 0.22};
    case Opening::shuttered: return {Surface::shutter, 0.08};
    case Opening::door: return {Surface::wood, 0.30};
    case Opening::display: return {Surface::windowGlass, 0.35};
    case Opening::none: break;
  }
  return {wall, 0};
}

void addReveals(MeshBuilder& builder, const Facade& facade, int column, int row, double depth) {
  const double left = facade.columns[column], right = facade.columns[column + 1];
  const double low = facade.rows[row], high = facade.rows[row + 1];
  const auto opening = facade.opening(column, row);
  const auto reveal = [&](int otherColumn, int otherRow, double c0, double r0, double c1, double r1) {
    const bool inside = otherColumn >= 0 && otherRow >= 0 &&
                        otherColumn + 1 < static_cast<int>(facade.columns.size()) &&
                        otherRow + 1 < static_cast<int>(facade.rows.size());
    if (inside && facade.opening(otherColumn, otherRow) == opening) return;
    builder.quad(facade.wall, facade.at(c0, r0), facade.at(c1, r1), facade.at(c1, r1, depth), facade.at(c0, r0, depth));
  };
  reveal(column, row - 1, left, low, right, low);
  reveal(column + 1, row, right, low, right, high);
  reveal(column, row + 1, right, high, left, high);
  reveal(column - 1, row, left, high, left, low);
}

}  // namespace

Vec3 Facade::at(double column, double row, double depth) const {
  const Vec3 inward = cross({0, 0, 1}, along);
  return corner + column * along + Vec3{0, 0, row} + depth * inward;
}

void addFacade(MeshBuilder& builder, const Facade& facade) {
  for (int row = 0; row + 1 < static_cast<int>(facade.rows.size()); ++row)
    for (int column = 0; column + 1 < static_cast<int>(facade.columns.size()); ++column) {
      const Opening opening = facade.opening(column, row);
      const Filling filling = fillingOf(opening, facade.wall);
      const double left = facade.columns[column], right = facade.columns[column + 1];
      const double low = facade.rows[row], high = facade.rows[row + 1];
      const double depth = filling.depth;
      builder.quad(filling.surface, facade.at(left, low, depth), facade.at(right, low, depth),
                   facade.at(right, high, depth), facade.at(left, high, depth));
      if (opening != Opening::none) addReveals(builder, facade, column, row, depth);
    }
}

std::vector<double> evenFields(double length, int count, double width) {
  std::vector<double> edges = {0};
  for (int i = 0; i < count; ++i) {
    const double middle = length * (2 * i + 1) / (2 * count);
    edges.push_back(middle - width / 2);
    edges.push_back(middle + width / 2);
  }
  edges.push_back(length);
  return edges;
}

}  // namespace gnosphere::town
