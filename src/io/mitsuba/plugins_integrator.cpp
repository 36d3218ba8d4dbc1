#include "io/mitsuba/context.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

using Names = std::vector<std::string>;

/// Integrators of Mitsuba 2.x and 3.x and ours, which stand for path lengths and a default algorithm.
const Names kTypes = {"path",     "direct",  "ptracer",    "light", "bdpt",        "vcm",
                      "mcmc_vcm", "volpath", "volpathmis", "mmlt",  "pssmlt_merge"};
/// Those of 0.x only.
const Names kLegacyTypes = {"photonmapper", "ppm", "sppm", "vpl", "pssmlt", "mlt", "erpt", "volpath_simple"};
/// Integrators around another one.
const Names kWrappers = {"aov", "moment"};

/// How samples are spent changes noise, not the image.
const Names kIgnored = {"samples_per_pass", "block_size",   "timeout",         "shading_samples",
                        "emitter_samples",  "bsdf_samples", "emitter_sampling"};
/// Of the integrators of 0.x, which files often leave behind when they change the type.
const Names kLegacyIgnored = {"strict_normals",
                              "sample_num",
                              "delta",
                              "photon_count",
                              "initial_radius",
                              "alpha",
                              "max_passes",
                              "granularity",
                              "light_image",
                              "sample_direct",
                              "direct_samples",
                              "glossy_samples",
                              "global_photons",
                              "caustic_photons",
                              "volume_photons",
                              "global_lookup_radius",
                              "caustic_lookup_radius",
                              "lookup_size",
                              "shadow_map_resolution",
                              "clamping",
                              "bidirectional",
                              "luminance_samples",
                              "two_stage",
                              "large_step",
                              "bidirectional_mutation",
                              "lens_perturbation",
                              "caustic_perturbation",
                              "multi_chain_perturbation",
                              "manifold_perturbation",
                              "lambda",
                              "num_chains",
                              "max_chains",
                              "chain_length",
                              "brute_force",
                              "direct_sampling",
                              "glossy_sampling",
                              "gather_locally",
                              "auto_cancel_gathering",
                              "first_stage_size_reduction"};

bool contains(const Names& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

void ignore(const Element& element, const Names& names, LoadContext& context) {
    std::string found;
    for (const auto& entry : element.named)
        if (contains(names, entry.first))
            found += fmt::format("{}\"{}\"", found.empty() ? "" : ", ", entry.first);
    for (const std::string& name : names) element.ignore(name);
    if (!found.empty()) context.warn(element, "no effect here: " + found);
}

int depthProperty(const Element& element, const std::string& name, int fallback, int64_t least) {
    const int64_t value = element.integer(name, fallback);
    if (value == -1 || (value >= least && value <= std::numeric_limits<int>::max()))
        return static_cast<int>(value);
    throw element.error(*element.find(name),
                        fmt::format("found {}, expected -1 or {} and more", value, least));
}

void readWrapped(const Element& element, LoadContext& context, SceneParts& parts) {
    ignore(element, {"aovs"}, context);
    ignore(element, kIgnored, context);
    const auto nested = element.childrenOf("integrator");
    if (nested.size() > 1)
        context.warn(element, fmt::format("uses the first of its {} nested integrators", nested.size()));
    if (nested.empty()) {
        context.warn(element, "has no nested integrator; paths of any length are rendered");
    } else {
        readIntegrator(*nested.front(), context, parts);
    }
}

}  // namespace

void readIntegrator(const Element& element, LoadContext& context, SceneParts& parts) {
    const std::string& type = element.type;
    if (contains(kWrappers, type)) {
        readWrapped(element, context, parts);
    } else if (contains(kTypes, type) || contains(kLegacyTypes, type)) {
        parts.integrator = type.starts_with("volpath") ? "path" : type;
        const bool direct = type == "direct";
        parts.limits.maxDepth = direct ? 2 : depthProperty(element, "max_depth", -1, 0);
        const int roulette = direct ? 5 : depthProperty(element, "rr_depth", 5, 1);
        parts.limits.rouletteDepth = roulette == -1 ? std::numeric_limits<int>::max() : roulette;
        parts.limits.hideEmitters = element.boolean("hide_emitters", false);
        ignore(element, kIgnored, context);
        if (element.isLegacy() || contains(kLegacyTypes, type) || type == "bdpt")
            ignore(element, kLegacyIgnored, context);
        if (direct && element.isLegacy()) ignore(element, {"max_depth", "rr_depth"}, context);
    } else {
        Names known = kTypes;
        known.insert(known.end(), kWrappers.begin(), kWrappers.end());
        known.insert(known.end(), kLegacyTypes.begin(), kLegacyTypes.end());
        const std::string nearest = nearestName(type, known);
        const Error error =
            element.error(nearest.empty() ? "unknown integrator"
                                          : fmt::format("unknown integrator; did you mean \"{}\"?", nearest));
        if (!context.lenient) throw error;
        context.warnings.push_back(std::string(error.what()) + "; paths of any length are rendered");
        return;
    }
    element.checkAllUsed(context.lenient, context.warnings);
}

}  // namespace metrolux::core::mitsuba
