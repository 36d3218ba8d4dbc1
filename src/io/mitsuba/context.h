#pragma once
/// What the plugin factories share while a scene is loaded.

#include "base/memory_budget.h"
#include "endpoint/camera.h"
#include "endpoint/light.h"
#include "geometry/shape.h"
#include "image/filter.h"
#include "image/image_io.h"
#include "io/mitsuba/properties.h"
#include "scattering/bsdf.h"
#include "scattering/texture.h"
#include "scene/scene.h"

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

namespace metrolux::core::mitsuba {

/// What the command line says about the film: makeCamera applies it over the scene's own.
struct FilmOverride {
    int width = 0, height = 0;  ///< 0: the film's
    bool hasCrop = false;
    int cropX = 0, cropY = 0, cropWidth = 0, cropHeight = 0;  ///< pixels of the full image
};

struct LoadContext {
    std::vector<std::filesystem::path>
        searchPaths;  ///< <path> elements, the last first; then the scene's folder
    FilmOverride film;
    bool lenient = false;
    /// Where the origin of what is being built lies, in the coordinates of the file: those of the scene, or
    /// of the shapegroup within which shapes are built (world_origin.h).
    Vec3d origin{0.0};
    Vec3d sceneOrigin{0.0};                           ///< the same of the scene, wherever shapes are built
    MemoryBudget memory = MemoryBudget::unlimited();  ///< what meshes, images and instances are booked on
    std::vector<std::string> warnings;
    /// Built objects by element, so that a shared <ref> is built once.
    std::unordered_map<const Element*, std::shared_ptr<const void>> built;

    std::vector<MediumPtr> media;  ///< of the scene, in the order of SceneParts::media
    std::unordered_map<const Element*, MediumIndex> mediumIndices;  ///< 0: left out

    /// Mesh attributes that the textures in an element read.
    std::unordered_map<const Element*, std::vector<std::string>> attributesRead;

    /// Existing file for a name in the scene; throws Error that lists where it was looked for.
    /// It is noted in `files`.
    std::filesystem::path resolve(const Element& element, const std::string& filename);
    std::set<std::filesystem::path> files;
    /// The image of a texture or an environment map: that of "filename", as readImage() has it, or the pixels
    /// of "data". Throws Error.
    ImageData image(const Element& element, bool raw);
    /// "to_world", into what is being built. As Element::transform().
    Transform toWorld(const Element& element, bool mayFlatten = false) const;
    /// A point of the file's world. Throws Error where nothing can be.
    Vec3f place(const Element& element, const Vec3d& position) const;
    void warn(const Element& element, const std::string& message) {
        warnings.emplace_back(element.error(message).what());
    }
};

/// Lets errors that do not know where they are about name the element.
template <class Make>
auto withLocation(const Element& element, Make&& make) {
    try {
        return make();
    } catch (const Error& error) {
        const std::string message = error.what();
        if (message.starts_with(element.location.file + ":")) throw;
        throw element.error(message);
    }
}

// One factory for each tag. An unknown type is an Error with the nearest known type (or, when lenient, a
// warning and a stand-in). Each calls element.checkAllUsed at its end.
BsdfPtr makeBsdf(const Element& element, LoadContext& context);  // plugins_bsdf.cpp
TexturePtr makeTexture(const Element& element, LoadContext& context,
                       bool emission = false);                     // plugins_texture.cpp
LightPtr makeLight(const Element& element, LoadContext& context);  // plugins_emitter.cpp: all but area
/// Null when it is left out.
LightPtr makeAreaLight(const Element& element, const Shape& shape,
                       LoadContext& context);  // plugins_emitter.cpp
CameraPtr makeCamera(const Element& element, LoadContext& context,
                     SceneParts& parts);  // plugins_sensor.cpp (reads the film)
/// Shapes with bsdf and emitter attached; area lights are appended to parts.lights.
void addShape(const Element& element, LoadContext& context, SceneParts& parts);  // plugins_shape.cpp
void readIntegrator(const Element& element, LoadContext& context,
                    SceneParts& parts);  // plugins_integrator.cpp

// The types that these know.
std::vector<std::string> bsdfTypes();
std::vector<std::string> textureTypes();
std::vector<std::string> emitterTypes();
std::vector<std::string> sensorTypes();
std::vector<std::string> filmTypes();
std::vector<std::string> shapeTypes();

/// The color of a number, <rgb> or <spectrum>, or nothing when the property is an element. Throws Error.
std::optional<Rgb> constantColor(const Element& element, const Property& property,
                                 Rgb (*convert)(const SpectrumValue&));
/// A property that may be a number, a color, a spectrum or a texture: reflectance-like, converted as such.
TexturePtr textureProperty(const Element& element, const std::string& name, LoadContext& context,
                           const Rgb& fallback);
/// The same for a scalar (roughness, weight ...).
TexturePtr scalarTextureProperty(const Element& element, const std::string& name, LoadContext& context,
                                 float fallback);
/// The same for an emitted quantity (radiance, intensity, irradiance): spectra convert as illuminants.
TexturePtr emissionProperty(const Element& element, const std::string& name, LoadContext& context,
                            const Rgb& fallback);
/// An index of refraction or absorption: number, rgb or spectrum without the [0,1] limit of reflectances.
Rgb unboundedColor(const Element& element, const std::string& name, LoadContext& context,
                   const Rgb& fallback);

}  // namespace metrolux::core::mitsuba
