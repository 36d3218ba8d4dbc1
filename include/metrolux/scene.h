#pragma once
#include <metrolux/object.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace metrolux {

struct Resolution {
    int width = 0, height = 0;
};

/// A rectangle of pixels of the full image, from its top left.
struct Crop {
    int x = 0, y = 0, width = 0, height = 0;
};

/// What replaces the film's own; what is absent stays. A film's crop follows a new resolution in proportion.
struct FilmChange {
    std::optional<Resolution> resolution;
    std::optional<Crop> crop;
    std::optional<std::string>
        filter;  ///< box, tent, gaussian, mitchell, catmullrom, lanczos: of default width
};

/// What replaces the limits of the scene's integrator.
struct PathChange {
    std::optional<int> maxDepth;  ///< edges; -1: no limit, 1: lights that are seen directly, 2: direct light
    std::optional<int> rouletteDepth;  ///< edges of a subpath before Russian roulette
    std::optional<bool> hideEmitters;  ///< lights are not seen directly
};

struct LoadOptions {
    std::map<std::string, std::string> defines;  ///< values of the scene's <default>s and $parameters
    bool lenient = false;  ///< unknown plugins and parameters are warned of, not refused
    bool strict = false;   ///< any warning is an Error
    std::string sensor;    ///< number (from 0) or id of one of several sensors; empty: the first
    FilmChange film;
    std::uint64_t memory = 0;  ///< bytes that the scene's data may take; 0: what the machine has
    int threads = 0;           ///< 0: one for each core
};

/// Sizes for people.
struct SceneSizes {
    std::size_t shapes = 0, instances = 0, primitives = 0, lights = 0;
};

/// A scene that can be rendered. It never changes: a handle is cheap to copy and may be used by several
/// threads and sessions at once. Scenes that are made from another one share all that is the same, geometry
/// above all.
class METROLUX_API Scene {
  public:
    /// Reads a Mitsuba scene (XML of version 3.x, 2.x, 0.6 or 0.5). Throws Error.
    static Scene load(const std::filesystem::path& file, const LoadOptions& options = {});
    /// From an object of type "scene", whose values are a sensor, shapes, emitters ... The name of a value
    /// serves as its id. Files are looked for in `folder` (empty: the working directory). Throws Error.
    static Scene make(const Object& scene, const LoadOptions& options = {},
                      const std::filesystem::path& folder = {});

    /// Seen by another sensor; without a film of its own it has this one's. Throws Error.
    Scene withCamera(const Object& sensor) const;
    /// With the camera elsewhere: its `to_world`. Throws Error.
    Scene withCamera(const Transform& toWorld) const;
    /// Throws Error.
    Scene withFilm(const FilmChange& change) const;
    Scene withPaths(const PathChange& change) const;

    /// What the scene says, by path: "lamp.emitter.radiance". A path is made of names with points between:
    /// directly in the scene an id (or the tag, "shape"), below it the name in the parent (or the tag). Where
    /// a name repeats, "_2", "_3" ... follow it. Defaults are not listed, nor are maps that flatten space.
    Object::Values values() const;
    /// With other values at such paths. A name that its parent does not have is added; an object takes the
    /// place of another for all who refer to it. What is outside of the sensor is built again, geometry
    /// included; files are read again. Throws Error.
    Scene with(const Object::Values& changes) const;

    /// Whether both have the same geometry in memory.
    bool sharesGeometryWith(const Scene& other) const;

    Resolution resolution() const;  ///< of the full image
    Crop window() const;            ///< the part of it that is rendered
    SceneSizes sizes() const;
    /// The type of the scene's <integrator>, "path" without one.
    std::string integrator() const;
    /// What is understood but has no effect, or was let pass.
    const std::vector<std::string>& warnings() const;
    /// Name of the file, or "scene".
    std::string source() const;

    struct Impl;

  private:
    friend struct Internals;
    explicit Scene(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
    std::shared_ptr<const Impl> impl_;
};

}  // namespace metrolux
