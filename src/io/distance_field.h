#pragma once
/// The surface of a signed distance field on a grid, as triangles.

#include "geometry/shape.h"
#include "media/grid_volume.h"

#include <functional>

namespace metrolux::core {

/// Where the trilinear interpolation of the samples is zero; they lie at the nodes of the unit cube, positive
/// outside of the body. Normals point outward. A cell is divided until there are some 100 along an axis, four
/// times at most, and each of the small cells into six tetrahedra [Doi & Koide 1991], so that the surface is
/// closed where the body is. `smooth`: vertices have the gradient between the nodes' central differences as
/// normals, otherwise they have none. `book` is told of the bytes that it takes, before. Unfinished
/// (finishMesh). Throws Error without a surface, or with less than two samples along an axis.
std::shared_ptr<TriangleMesh> meshOfDistances(const GridSamples& samples, bool smooth,
                                              const std::function<void(uint64_t)>& book);

}  // namespace metrolux::core
