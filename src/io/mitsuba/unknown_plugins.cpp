#include "io/mitsuba/unknown_plugins.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

/// Plugins of Mitsuba 0.6, 2 and 3 that are not there, with what comes nearest.
struct Missing {
    const char* tag;
    const char* type;
    const char* nearest;
};
constexpr Missing kMissing[] = {
    {"bsdf", "measured", "roughconductor, principled"},
    {"bsdf", "measured_polarized", "roughconductor; images are not polarized"},
    {"bsdf", "hair", "principled"},
    {"bsdf", "irawan", "diffuse with a bitmap"},
    {"bsdf", "hk", "difftrans, or a medium between two surfaces"},
    {"shape", "ellipsoids", "sphere"},
    {"shape", "ellipsoidsmesh", "a mesh"},
    {"shape", "deformable", "a mesh; scenes do not move"},
    {"shape", "animatedinstance", "instance; scenes do not move"},
    {"texture", "volume", "bitmap"},
    {"texture", "wireframe", "bitmap"},
    {"texture", "curvature", "mesh_attribute with values that another program has computed"},
    {"emitter", "timed_sunsky", "sunsky"},
    {"emitter", "directionalarea", "area, collimated"},
    {"emitter", "volumelight", "area; media do not emit"},
    {"sensor", "batch", "one sensor at a time (--sensor)"},
    {"sensor", "distant", "orthographic"},
    {"sensor", "hdistant", "orthographic"},
    {"sensor", "mdistant", "orthographic"},
    {"sensor", "irradiancemeter", "fisheye"},
    {"sensor", "fluencemeter", "spherical"},
    {"sensor", "mpdistant", "orthographic"},
    {"sensor", "planar_irradiancemeter", "perspective"},
    {"sensor", "microphone", "perspective"},
    {"sensor", "environment", "spherical"},
    {"sensor", "panorama", "spherical"},
    {"sensor", "telecentric", "orthographic"},
    {"sensor", "perspective_rdist", "perspective, without the distortion"},
    {"medium", "specmedium", "homogeneous"},
    {"phase", "sggx", "isotropic or hg; scattering depends on the angle alone, not on orientation"},
    {"phase", "kkay", "isotropic or hg; scattering depends on the angle alone, not on orientation"},
    {"phase", "microflake", "isotropic or hg; scattering depends on the angle alone, not on orientation"},
    {"volume", "hgridvolume", "gridvolume"},
    {"volume", "volcache", "the volume in it"},
    {"subsurface", "singlescatter", "dipole, or a medium in a dielectric"},
    {"film", "specfilm", "hdrfilm; images are RGB"},
};

}  // namespace

std::string unknownPlugin(const Element& element, const std::string& kind,
                          const std::vector<std::string>& known) {
    const auto* missing = std::find_if(std::begin(kMissing), std::end(kMissing), [&](const Missing& m) {
        return element.tag == m.tag && element.type == m.type;
    });
    if (missing != std::end(kMissing))
        return fmt::format("Mitsuba's {} \"{}\" is not supported; nearest: {}", kind, element.type,
                           missing->nearest);
    const std::string nearest = nearestName(element.type, known);
    return nearest.empty() ? fmt::format("unknown {} type, expected one of: {}", kind, fmt::join(known, ", "))
                           : fmt::format("unknown {} type; did you mean \"{}\"?", kind, nearest);
}

}  // namespace metrolux::core::mitsuba
