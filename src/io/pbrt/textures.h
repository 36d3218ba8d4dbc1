#pragma once
/// Textures of pbrt as values that can be computed with: a constant, an image, a choice between two others,
/// or noise in space. What cannot be computed when the scene is read is a product or a sum of two.

#include "io/mitsuba/maker.h"
#include "io/pbrt/spectra.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>

namespace metrolux::core::pbrt {

/// How uv are found: those of the surface, or by the position of the point.
struct Mapping {
    std::string kind = "uv";   ///< or spherical, cylindrical, planar
    Transform toTexture = {};  ///< from the world
    Transform toUv = {};       ///< of what is found
};
bool operator==(const Mapping& a, const Mapping& b);

class Texture {
  public:
    explicit Texture(const Rgb& constant) : constant_(constant) {}

    /// Two in turn: squares of uv, cubes in space (`kind` "cubes"), or discs on a ground ("discs"). Throws
    /// Error where they are nested too deep: each doubles what there is to say.
    static Texture choice(const char* kind, Texture first, Texture second, const Mapping& mapping,
                          const Location& where);
    /// Noise: `element` has its numbers, `colors` are what its values are looked up in.
    struct Noise {
        mitsuba::ElementPtr element;
        std::vector<Rgb> colors;
    };
    static Texture noise(Noise noise, const Location& where);
    struct Image {
        int width = 0, height = 0;
        std::shared_ptr<const std::vector<float>> pixels;  ///< three for each, rows from the top
        std::string wrap = "repeat";
        bool nearest = false;
    };
    static Texture image(Image image, const Mapping& mapping, const Location& where);

    bool isConstant() const { return kind_ == Kind::Constant; }
    /// The color of a constant.
    const Rgb& constant() const { return constant_; }
    /// Of all colors that it has: the largest in each channel.
    Rgb largest() const;
    Rgb mean() const;
    /// With `change` applied to each color. Throws Error for products and sums of what is mapped in different
    /// ways.
    Texture changed(const std::function<Rgb(const Rgb&)>& change, MemoryBudget& memory) const;
    enum class Operation { Product, Sum };
    static Texture combined(const Texture& a, const Texture& b, Operation operation, MemoryBudget& memory);
    /// Adds it to an element as the value `name`: as a color, or as a number.
    void addTo(mitsuba::Maker& element, const std::string& name, bool asNumber) const;
    mitsuba::ElementPtr element(bool asNumber) const;

  private:
    enum class Kind { Constant, Image, Choice, Noise, Combination };
    Rgb at(double u, double v) const;
    static Texture later(const Texture& a, const Texture& b, Operation operation);
    void requireDepth() const;
    mitsuba::ElementPtr choiceElement(bool asNumber) const;
    mitsuba::ElementPtr mapped(mitsuba::ElementPtr nested) const;

    Kind kind_ = Kind::Constant;
    int depth_ = 0;  ///< of choices and combinations within each other
    Rgb constant_{0.0f};
    Image image_;
    std::shared_ptr<const Texture> first_, second_;
    std::string choice_;  ///< "squares", "cubes", "discs"
    std::optional<Noise> noise_;
    Operation operation_ = Operation::Product;
    Mapping mapping_;
    Location where_;
};

/// The named textures of a scene, and what parameters say by them or by value.
class Textures {
  public:
    explicit Textures(Reading& reading) : reading_(reading) {}

    /// Texture "name" "type" "class", under a map to the world.
    void define(const std::string& name, const std::string& type, const std::string& kind,
                const Parameters& parameters, const ColorSpace& space, const Transform& toWorld);

    // A parameter that may be a texture, or the fallback.
    Texture color(const Parameters& parameters, const std::string& name, const Rgb& fallback,
                  const ColorSpace& space);
    Texture number(const Parameters& parameters, const std::string& name, double fallback);
    /// An image file as pbrt's `imagemap` reads it. `raw`: numbers that are no colors.
    Texture imageFile(const std::string& file, const Parameters& parameters, bool raw,
                      const ColorSpace& space);

  private:
    Texture named(const Parameter& parameter);
    Texture make(const std::string& kind, const Parameters& parameters, bool isColor,
                 const ColorSpace& space);

    Mapping mappingOf(const Parameters& parameters) const;
    Texture noise(const std::string& kind, const Parameters& parameters, bool isColor) const;

    Reading& reading_;
    Transform toWorld_;  ///< of the texture that is being made
    std::map<std::string, Texture> textures_;
    std::map<std::pair<std::string, bool>, Texture::Image> images_;
};

}  // namespace metrolux::core::pbrt
