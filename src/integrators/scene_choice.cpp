#include "integrators/scene_choice.h"

#include "base/suggest.h"

#include <algorithm>
#include <utility>

namespace metrolux::core {

namespace {

using Names = std::vector<std::string>;

bool contains(const Names& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Settings of Mitsuba's integrators that say how samples are spent: they change noise, not the image.
const Names kWithoutEffect = {"samples_per_pass", "block_size",   "timeout",          "shading_samples",
                              "emitter_samples",  "bsdf_samples", "emitter_sampling", "use_spectral_mis"};
/// Those of 0.x, whose files often leave settings behind when they change the type.
const Names kLegacyWithoutEffect = {"strict_normals",
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
                                    "p_large",
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
/// Types of 0.x only: their settings are old ones in a scene of any version.
const Names kLegacyTypes = {"photonmapper", "ppm", "sppm", "pssmlt", "mlt", "volpath_simple", "bdpt"};

/// Mitsuba's integrators that have no counterpart here, and what one would render with instead.
struct Foreign {
    const char* type;
    const char* nearest;
};
constexpr Foreign kForeign[] = {{"erpt", "pssmlt"},
                                {"vpl", "bdpt"},
                                {"prb", "path"},
                                {"prb_basic", "path"},
                                {"prb_projective", "path"},
                                {"prb_reparam", "path"},
                                {"prbvolpath", "path"},
                                {"direct_projective", "path"},
                                {"direct_reparam", "path"},
                                {"emission_reparam", "path"},
                                {"singlescatter", "path"}};

bool isWithoutEffect(const SceneIntegrator& scene, const std::string& setting) {
    return contains(kWithoutEffect, setting) ||
           ((scene.legacy || contains(kLegacyTypes, scene.type)) && contains(kLegacyWithoutEffect, setting));
}

Names knownTypes() {
    Names types;
    for (const IntegratorDescription& integrator : integratorList()) {
        types.push_back(integrator.name);
        types.insert(types.end(), integrator.mitsubaTypes.begin(), integrator.mitsubaTypes.end());
    }
    return types;
}

/// What is wrong with a type that has no counterpart.
std::string problemOf(const SceneIntegrator& scene) {
    for (const Foreign& foreign : kForeign)
        if (scene.type == foreign.type)
            return fmt::format("this integrator of Mitsuba is not supported; nearest is \"{}\"",
                               foreign.nearest);
    const std::string nearest = nearestName(scene.type, knownTypes());
    return nearest.empty() ? "unknown integrator"
                           : fmt::format("unknown integrator; did you mean \"{}\"?", nearest);
}

/// What may have been meant by a setting that the integrator does not have.
std::string suggestion(const ParameterSet& set, const std::string& setting) {
    Names names{"max_depth", "rr_depth", "hide_emitters"};
    for (const ParameterInfo& info : set.list()) names.push_back(info.name);
    const std::string nearest = nearestName(setting, names);
    return nearest.empty() ? fmt::format("expected one of {}", fmt::join(names, ", "))
                           : fmt::format("did you mean \"{}\"?", nearest);
}

}  // namespace

const IntegratorDescription* integratorOf(const SceneIntegrator& scene) {
    for (const IntegratorDescription& integrator : integratorList())
        if (integrator.name == scene.type || contains(integrator.mitsubaTypes, scene.type))
            return &integrator;
    return nullptr;
}

void settleSceneIntegrator(SceneParts& parts, bool lenient) {
    SceneIntegrator& scene = parts.integrator;
    const IntegratorDescription* integrator = integratorOf(scene);
    std::vector<SceneIntegrator::Setting> found = std::exchange(scene.settings, {});
    if (!integrator) {
        parts.warnings.push_back(fmt::format("{}: {}; of its settings only those of path lengths are used",
                                             scene.where, problemOf(scene)));
        return;
    }
    ParameterSet set(integrator->parameters);
    std::string withoutEffect;
    for (SceneIntegrator::Setting& setting : found) {
        try {
            if (const ParameterInfo* info = set.findByAnyName(setting.name)) {
                set.set(info->name, setting.value, setting.where);
                setting.name = info->name;
                scene.settings.push_back(std::move(setting));
            } else if (isWithoutEffect(scene, setting.name)) {
                withoutEffect += fmt::format("{}\"{}\"", withoutEffect.empty() ? "" : ", ", setting.name);
            } else {
                const Error unused("{}: is not used by this integrator; {}", setting.where,
                                   suggestion(set, setting.name));
                if (!scene.legacy) throw unused;
                parts.warnings.emplace_back(unused.what());  // as Mitsuba 0.6
            }
        } catch (const Error& problem) {
            if (!lenient) throw;
            parts.warnings.emplace_back(problem.what());
        }
    }
    if (!withoutEffect.empty())
        parts.warnings.push_back(fmt::format("{}: no effect here: {}", scene.where, withoutEffect));
}

IntegratorChoice chooseIntegrator(const std::string& chosen, const SceneIntegrator& scene,
                                  const ParameterValues& given) {
    const IntegratorDescription* const ofScene = integratorOf(scene);
    const bool asTheScene = chosen == kSceneIntegrator;
    if (asTheScene && !ofScene)
        throw Error("{}: {}; choose one with --integrator, of {}", scene.where, problemOf(scene),
                    fmt::join(knownTypes(), ", "));
    const IntegratorDescription& integrator = asTheScene ? *ofScene : findIntegrator(chosen);
    IntegratorChoice choice{&integrator, ParameterSet(integrator.parameters)};
    if (&integrator == ofScene)
        for (const SceneIntegrator::Setting& setting : scene.settings)
            choice.parameters.set(setting.name, setting.value, setting.where);
    for (const auto& [name, value] : given) choice.parameters.set(name, value);
    return choice;
}

}  // namespace metrolux::core
