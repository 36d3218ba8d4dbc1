#pragma once
/// A plugin element of a Mitsuba scene (<bsdf type="..."> ...) with its typed properties and children, after
/// includes, defaults, references and the upgrade of 0.5/0.6 names. Every property that is read is marked;
/// what is left over is an error that names file, line and element and suggests the nearest name that the
/// plugin knows.

#include "base/error.h"
#include "base/math.h"
#include "base/suggest.h"
#include "base/transform.h"

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace metrolux::core::mitsuba {

/// Where something stands, for messages: "scene.xml:12", or "scene:lamp.emitter" in one that was made in
/// code.
struct Location {
    std::string file;
    int line = 0;
    std::string path = {};  ///< in place of the line, empty for the whole
    std::string str() const {
        if (line > 0) return file + ":" + std::to_string(line);
        return path.empty() ? file : file + ":" + path;
    }
};

class Element;
using ElementPtr = std::shared_ptr<const Element>;

/// <rgb value="..."/>, and <srgb>: already linear.
struct RgbValue {
    Rgb value;
};
/// <spectrum value="..."/> or a blackbody: wavelength-value pairs, or one uniform value. Converted by what
/// reads it, because reflectances and emission convert differently (io/mitsuba/spectrum.h).
struct SpectrumValue {
    std::vector<float> wavelengths;  ///< nanometers, ascending; empty for a uniform value
    std::vector<float> values;
    float blackbodyKelvin = 0;  ///< > 0: Planck's law, `values[0]` is the scale
};

/// The arrays of a mesh that is in no file of its own, as their owner keeps them.
struct MeshArrays {
    std::span<const float> positions, normals;  ///< three numbers per vertex; normals may be empty
    std::span<const float> uvs;                 ///< two per vertex, or empty
    std::span<const uint32_t> triangles;        ///< three vertices each
    struct Attribute {
        std::string name;  ///< TriangleMesh::Attribute
        int channels;
        std::span<const float> values;
    };
    std::vector<Attribute> attributes;
    std::shared_ptr<const void> owner;
    bool isMesh = false;  ///< the owner is a metrolux::Mesh
};

/// The pixels of an image that was made in code, as their owner keeps them: row by row from the top, channels
/// interleaved.
struct PixelArray {
    int width = 0, height = 0, channels = 0;
    std::span<const float> pixels;
    std::shared_ptr<const void> owner;
    bool isImage = false;  ///< the owner is a metrolux::Image
};

/// The samples of a volume that is in no file of its own, as their owner keeps them (GridSamples).
struct VoxelArray {
    std::array<int, 3> resolution{};
    int channels = 0;
    std::span<const float> values;
    std::shared_ptr<const void> owner;
};

struct Property {
    std::variant<bool, int64_t, double, std::string, Vec3d, Transform, RgbValue, SpectrumValue, ElementPtr,
                 MeshArrays, PixelArray, VoxelArray>
        value;
    Location location;
    mutable bool used = false;
    int order = 0;          ///< position among everything that its element contains
    std::string text = {};  ///< of a <transform> in a file: its steps, with all parameters replaced
};

/// A child of an element with the name that it has there, empty for none.
struct NamedChild {
    std::string name;
    ElementPtr element;
};

class Element {
  public:
    std::string tag;   ///< "bsdf", "shape", "emitter" ...
    std::string type;  ///< plugin type, lower case as written
    std::string id;    ///< empty if it has none
    Location location;
    std::vector<std::pair<std::string, Property>> named;  ///< in order of appearance; names in 3.x form
    std::vector<Property> children;  ///< nested elements without a name (ElementPtr each)

    bool has(const std::string& name) const { return find(name) != nullptr; }
    const Property* find(
        const std::string& name) const;  ///< also marks the name as known; does not mark it used

    // Typed access; marks the property as used; throws Error (file, line, element, found, expected) on a
    // wrong type.
    bool boolean(const std::string& name, bool fallback) const;
    int64_t integer(const std::string& name, int64_t fallback) const;
    /// Throws for NaN and infinity.
    float number(const std::string& name, float fallback) const;
    std::string string(const std::string& name, const std::string& fallback) const;
    std::string requiredString(const std::string& name) const;
    Vec3f vector(const std::string& name, const Vec3f& fallback) const;  ///< <point> or <vector>
    Vec3d point(const std::string& name, const Vec3d& fallback) const;   ///< the same, as settled()
    /// Identity if absent. Throws for a singular map, unless it `mayFlatten`.
    Transform transform(const std::string& name, bool mayFlatten = false) const;
    const MeshArrays& requiredArrays(const std::string& name) const;
    /// Null if absent.
    const PixelArray* pixels(const std::string& name) const;
    /// The same.
    const VoxelArray* voxels(const std::string& name) const;
    /// A nested or referenced element under this name, or null.
    ElementPtr child(const std::string& name) const;
    /// All elements with the tag ("bsdf", "emitter", ...), named or not, in order of appearance; marked used.
    /// (A shape takes <ref name="bsdf" id="..."/> as well as <ref id="..."/>, a bumpmap's texture has any
    /// name.)
    std::vector<ElementPtr> childrenOf(const std::string& tag) const;
    /// The same with their names.
    std::vector<NamedChild> namedChildrenOf(const std::string& tag) const;
    /// Reads and forgets a property that has no effect here (near_clip's relatives, sampler settings ...).
    void ignore(const std::string& name) const;

    /// Error text that begins with the location and the element: `scene.xml:12: <bsdf type="plastic">: ...`.
    Error error(const std::string& message) const;
    Error error(const Property& property, const std::string& message) const;

    /// Throws (or, if lenient, appends a warning) for each property or child that nothing has read, with the
    /// nearest known name; for values in a 0.x scene it is always a warning, as in Mitsuba 0.6. To be called
    /// once the plugin is built.
    void checkAllUsed(bool lenient, std::vector<std::string>& warnings) const;

    int version = 3;  ///< major version of the file: names, defaults and what is an error follow it
    bool isLegacy() const { return version < 2; }

  private:
    mutable std::vector<std::string> known_;  // names that were asked for: candidates for suggestions
};

}  // namespace metrolux::core::mitsuba
