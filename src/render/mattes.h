#pragma once
#include "image/cryptomatte.h"
#include "render/surface_names.h"

#include <vector>

namespace metrolux::core {

inline constexpr const char* kObjectMattes = "crypto_object";
inline constexpr const char* kMaterialMattes = "crypto_material";

/// Mattes of the objects and of the materials that camera rays meet first, through the film's reconstruction
/// filter; of those that are wanted. Where nothing is met nothing has a share.
std::vector<Cryptomatte> renderMattes(const Scene& scene, const SurfaceNames& names, bool objects,
                                      bool materials);

}  // namespace metrolux::core
