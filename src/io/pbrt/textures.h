#pragma once
/// Textures of pbrt as values that can be computed with: a constant, an image under a map of uv, or a
/// checkerboard of two others.

#include "io/mitsuba/maker.h"
#include "io/pbrt/spectra.h"

#include <functional>
#include <map>
#include <memory>

namespace metrolux::core::pbrt {

class Texture {
  public:
    explicit Texture(const Rgb& constant) : constant_(constant) {}

    /// Throws Error where checkerboards are nested too deep: each doubles what there is to say.
    static Texture checkerboard(Texture even, Texture odd, const Transform& toUv, const Location& where);
    struct Image {
        int width = 0, height = 0;
        std::shared_ptr<const std::vector<float>> pixels;  ///< three for each, rows from the top
        std::string wrap = "repeat";
        bool nearest = false;
    };
    static Texture image(Image image, const Transform& toUv, const Location& where);

    bool isConstant() const { return kind_ == Kind::Constant; }
    /// The color of a constant.
    const Rgb& constant() const { return constant_; }
    /// Of all colors that it has: the largest in each channel.
    Rgb largest() const;
    Rgb mean() const;
    /// With `change` applied to each color.
    Texture changed(const std::function<Rgb(const Rgb&)>& change, MemoryBudget& memory) const;
    /// f(a, b) everywhere. Throws Error for images that lie on the surface in different ways.
    static Texture combined(const Texture& a, const Texture& b,
                            const std::function<Rgb(const Rgb&, const Rgb&)>& f, MemoryBudget& memory);
    /// Adds it to an element as the value `name`: as a color, or as a number.
    void addTo(mitsuba::Maker& element, const std::string& name, bool asNumber) const;
    mitsuba::ElementPtr element(bool asNumber) const;

  private:
    enum class Kind { Constant, Image, Checkerboard };
    Rgb at(double u, double v) const;

    Kind kind_ = Kind::Constant;
    int depth_ = 0;  ///< of checkerboards within each other
    Rgb constant_{0.0f};
    Image image_;
    std::shared_ptr<const Texture> even_, odd_;
    Transform toUv_;
    Location where_;
};

/// The named textures of a scene, and what parameters say by them or by value.
class Textures {
  public:
    explicit Textures(Reading& reading) : reading_(reading) {}

    /// Texture "name" "type" "class".
    void define(const std::string& name, const std::string& type, const std::string& kind,
                const Parameters& parameters, const ColorSpace& space);

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

    Reading& reading_;
    std::map<std::string, Texture> textures_;
    std::map<std::pair<std::string, bool>, Texture::Image> images_;
};

}  // namespace metrolux::core::pbrt
