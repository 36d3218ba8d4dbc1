#pragma once
/// <ref>, <alias> and ids, resolved once the whole document is known.

#include "io/mitsuba/properties.h"

#include <map>
#include <memory>
#include <set>
#include <vector>

namespace metrolux::core::mitsuba {

/// Elements inside elements, references followed: what a plugin's factory may have to recurse.
inline constexpr int kMaxDepth = 256;
/// Parts of one BSDF, texture or phase function, each counted as often as it is referred to: evaluation
/// visits them all, and 60 blends of two references to the next would be 2^60.
inline constexpr uint64_t kMaxParts = 4096;

class References {
  public:
    /// All elements must be announced, their ids are noted. Throws Error for a duplicate id.
    void addElement(const std::shared_ptr<Element>& element);
    /// The property `name` of `parent`, or without a name the child with this order, is to become what `id`
    /// names.
    void addReference(Element& parent, int order, const std::string& name, const std::string& id,
                      const Location& location);
    void addAlias(const std::string& id, const std::string& as, const Location& location);
    /// Links all references. Throws Error for an unknown id, a cycle, more than kMaxDepth levels, and a
    /// BSDF, texture or phase function of more than kMaxParts parts.
    void resolve();
    const std::set<const Element*>& referenced() const { return referenced_; }

  private:
    struct Reference {
        Element* parent;
        int order;
        bool named;
        std::string id;
        Location location;
        std::shared_ptr<Element> target;
    };
    struct Alias {
        std::string id;
        Location location;
    };
    std::shared_ptr<Element> find(const Reference& reference) const;
    /// Elements with those that they contain or refer to, by index.
    using Graph = std::vector<std::vector<size_t>>;
    Graph graph() const;
    void checkGraph() const;
    void checkParts(const Graph& below, const std::vector<size_t>& sorted) const;

    std::vector<std::shared_ptr<Element>> elements_;
    std::vector<Reference> references_;
    std::map<std::string, std::shared_ptr<Element>> ids_;
    std::map<std::string, Alias> aliases_;
    std::set<const Element*> referenced_;
};

}  // namespace metrolux::core::mitsuba
