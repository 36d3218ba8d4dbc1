#pragma once
/// A glTF 2.0 file: its JSON, and what its buffers hold. What the values mean is not known here.
/// (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html)

#include "base/error.h"
#include "base/memory_budget.h"
#include "image/image_io.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace metrolux::core::gltf {

using Json = nlohmann::json;

/// A value with its place, for messages: "scene.gltf:materials.2.emissiveFactor".
class Node {
  public:
    Node(const std::string& file, std::string path, const Json& json)
        : file_(&file), path_(std::move(path)), json_(&json) {}

    bool has(const char* key) const { return json_->is_object() && json_->contains(key); }
    /// What stands under a key; an empty object where nothing does.
    Node at(const char* key) const;
    size_t size() const { return json_->is_array() ? json_->size() : 0; }
    /// An element of an array. Throws Error for an index beyond its end.
    Node at(size_t index) const;
    /// The extension of this name; an empty object without it.
    Node extension(const char* name) const { return at("extensions").at(name); }

    // Values under a key, with fallbacks; throw Error for another type.
    double number(const char* key, double fallback) const;
    bool boolean(const char* key, bool fallback) const;
    std::string string(const char* key, const std::string& fallback) const;
    /// Not negative; -1 where there is none.
    int64_t index(const char* key) const;
    /// So many numbers. Throws Error for another count.
    std::vector<double> numbers(const char* key, const std::vector<double>& fallback) const;

    const Json& json() const { return *json_; }
    const std::string& file() const { return *file_; }
    const std::string& path() const { return path_; }
    Error error(const std::string& message) const;

  private:
    const std::string* file_;
    std::string path_;
    const Json* json_;
};

class Document {
  public:
    /// Reads JSON or binary glTF, and all buffers. Throws Error.
    Document(const std::filesystem::path& file, MemoryBudget& memory);

    Node root() const { return {name_, "", json_}; }
    /// An element of one of the arrays at the top. Throws Error beyond its end.
    Node element(const char* array, size_t index) const { return root().at(array).at(index); }

    /// Elements of an accessor with `components` numbers each; integers that are normalized are fractions.
    std::vector<float> floats(size_t accessor, int components) const;
    /// How many components its elements have: 1 to 4.
    int components(size_t accessor) const;
    std::vector<uint32_t> indices(size_t accessor) const;
    /// Decoded; linear unless `raw`.
    ImageData image(size_t index, bool raw) const;

    /// All files that were read.
    const std::set<std::string>& files() const { return files_; }

  private:
    struct View;
    View view(size_t index) const;
    View elements(const Node& accessor, size_t elementBytes) const;
    std::string resource(const Node& owner, const std::string& uri) const;

    std::filesystem::path file_;
    std::string name_;
    MemoryBudget& memory_;
    Json json_;
    std::vector<std::string> buffers_;
    mutable std::set<std::string> files_;
};

}  // namespace metrolux::core::gltf
