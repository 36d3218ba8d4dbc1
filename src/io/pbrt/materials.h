#pragma once
#include "io/pbrt/textures.h"

#include <set>

namespace metrolux::core::pbrt {

/// The materials of a scene, as BSDFs. Named ones are made when something has them.
class Materials {
  public:
    Materials(Reading& reading, Textures& textures) : reading_(reading), textures_(textures) {}

    struct Definition {
        std::string type;
        Parameters parameters;
        ColorSpace space;
        mitsuba::ElementPtr made = {};
    };
    using Handle = std::shared_ptr<Definition>;

    /// MakeNamedMaterial.
    void name(const std::string& name, Handle material) { named_[name] = std::move(material); }
    /// NamedMaterial. Throws Error for an unknown name.
    Handle find(const std::string& name, const Parameters& where) const;
    /// The BSDF, made once.
    mitsuba::ElementPtr bsdf(const Handle& material);

    /// Types that are read, for messages and documents.
    static std::vector<std::string> types();

  private:
    friend struct MaterialMaker;
    Reading& reading_;
    Textures& textures_;
    std::map<std::string, Handle> named_;
    std::set<const Definition*> beingMade_;
};

}  // namespace metrolux::core::pbrt
