#pragma once
#include "io/gltf/document.h"
#include "io/mitsuba/properties.h"

namespace metrolux::core::gltf {

/// BSDFs and emitters of the materials of a glTF file.
class Materials {
  public:
    Materials(const Document& document, MemoryBudget& memory, std::vector<std::string>& warnings)
        : document_(document), memory_(memory), warnings_(warnings) {}

    /// Of a material by number, -1 for the default one. `colored`: the mesh has the attribute "vertex_color",
    /// into which the material's color is multiplied already. Made once for each.
    mitsuba::ElementPtr bsdf(int64_t material, bool colored);
    /// Null for one that does not emit.
    mitsuba::ElementPtr emitter(int64_t material);
    /// What absorbs in a body of this material, null for nothing. Made once.
    mitsuba::ElementPtr interior(int64_t material);
    /// Of the base color; one where vertices carry it.
    Rgb baseColorFactor(int64_t material) const;

  private:
    struct Texture;
    Node node(int64_t material) const;
    mitsuba::ElementPtr makeBsdf(const Node& material, bool colored);
    mitsuba::ElementPtr surface(const Node& material, bool colored);
    mitsuba::ElementPtr masked(const Node& material, mitsuba::ElementPtr nested);
    mitsuba::ElementPtr bent(const Node& material, mitsuba::ElementPtr nested);
    /// A bitmap of what `pixel(rgba, out)` makes of each texel.
    template <class Pixel>
    mitsuba::ElementPtr texture(const Node& info, bool raw, int channels, const Pixel& pixel);
    const ImageData& image(size_t index, bool raw);
    void warn(const Node& node, const std::string& message) {
        warnings_.emplace_back(node.error(message).what());
    }

    const Document& document_;
    MemoryBudget& memory_;
    std::vector<std::string>& warnings_;
    std::map<std::pair<int64_t, bool>, mitsuba::ElementPtr> bsdfs_;
    std::map<int64_t, mitsuba::ElementPtr> interiors_;
    std::map<std::pair<size_t, bool>, ImageData> images_;
};

}  // namespace metrolux::core::gltf
