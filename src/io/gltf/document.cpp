#include "io/gltf/document.h"

#include "base/error.h"
#include "io/mesh_io.h"
#include "io/mitsuba/parser.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace metrolux::core::gltf {
namespace {

namespace fs = std::filesystem;

/// What the JSON takes in memory for each byte of its text, as an allowance.
constexpr uint64_t kJsonBytes = 16;
constexpr uint32_t kMagic = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;

uint32_t word(std::string_view bytes, size_t at) {
    uint32_t value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::string base64(const Node& owner, std::string_view text) {
    std::string result;
    uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        if (c == '=') break;
        const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                          : c >= 'a' && c <= 'z' ? c - 'a' + 26
                          : c >= '0' && c <= '9' ? c - '0' + 52
                          : c == '+'             ? 62
                          : c == '/'             ? 63
                                                 : -1;
        if (value < 0) throw owner.error("found an \"uri\" that is not base64");
        bits = bits << 6 | static_cast<uint32_t>(value);
        if ((count += 6) < 8) continue;
        count -= 8;
        result += static_cast<char>(bits >> count & 0xffu);
    }
    return result;
}

/// "%20" and its like.
std::string decoded(const std::string& uri) {
    std::string result;
    for (size_t i = 0; i < uri.size(); ++i) {
        const auto digit = [&](size_t at) {
            const char c = at < uri.size() ? uri[at] : 'x';
            return c >= '0' && c <= '9'   ? c - '0'
                   : c >= 'a' && c <= 'f' ? c - 'a' + 10
                   : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                          : -1;
        };
        if (uri[i] == '%' && digit(i + 1) >= 0 && digit(i + 2) >= 0) {
            result += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
            i += 2;
        } else {
            result += uri[i];
        }
    }
    return result;
}

struct ComponentType {
    int64_t code;
    size_t bytes;
    double most;  ///< of a normalized integer; 0 for floating point
    double (*read)(const char*);
};
template <class T>
double readAs(const char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
}
constexpr ComponentType kComponentTypes[] = {
    {5120, 1, 127, readAs<int8_t>},          {5121, 1, 255, readAs<uint8_t>},
    {5122, 2, 32767, readAs<int16_t>},       {5123, 2, 65535, readAs<uint16_t>},
    {5125, 4, 4294967295, readAs<uint32_t>}, {5126, 4, 0, readAs<float>}};

const ComponentType& componentType(const Node& node) {
    const int64_t code = node.index("componentType");
    for (const ComponentType& type : kComponentTypes)
        if (type.code == code) return type;
    throw node.error(fmt::format("found the componentType {}, expected 5120 to 5126", code));
}

int componentsOf(const Node& accessor) {
    const std::string type = accessor.string("type", "");
    for (const auto& [name, count] : {std::pair("SCALAR", 1), {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}})
        if (type == name) return count;
    throw accessor.error(fmt::format("found the type \"{}\", expected SCALAR, VEC2, VEC3 or VEC4", type));
}

/// A count that the memory allows.
size_t countOf(const Node& node, uint64_t bytesEach, const MemoryBudget& memory) {
    const int64_t count = node.index("count");
    if (count < 0) throw node.error("has no \"count\", expected a number of elements");
    if (static_cast<uint64_t>(count) > (uint64_t{1} << 40) / bytesEach)
        throw node.error(fmt::format("found {} elements, expected fewer", count));
    memory.require(static_cast<uint64_t>(count) * bytesEach, "the accessor");
    return static_cast<size_t>(count);
}

}  // namespace

Error Node::error(const std::string& message) const {
    return Error("{}:{}: {}", *file_, path_.empty() ? "glTF" : path_, message);
}

Node Node::at(const char* key) const {
    static const Json nothing = Json::object();
    const std::string path = path_.empty() ? key : path_ + "." + key;
    return {*file_, path, has(key) ? (*json_)[key] : nothing};
}

Node Node::at(size_t index) const {
    if (index >= size())
        throw error(fmt::format("found a reference to number {}, but there are {}", index, size()));
    return {*file_, fmt::format("{}.{}", path_, index), (*json_)[index]};
}

double Node::number(const char* key, double fallback) const {
    if (!has(key)) return fallback;
    const Json& value = (*json_)[key];
    if (!value.is_number()) throw error(fmt::format("\"{}\" is no number, expected one", key));
    return value.get<double>();
}

bool Node::boolean(const char* key, bool fallback) const {
    if (!has(key)) return fallback;
    const Json& value = (*json_)[key];
    if (!value.is_boolean()) throw error(fmt::format("\"{}\" is neither true nor false", key));
    return value.get<bool>();
}

std::string Node::string(const char* key, const std::string& fallback) const {
    if (!has(key)) return fallback;
    const Json& value = (*json_)[key];
    if (!value.is_string()) throw error(fmt::format("\"{}\" is no string, expected one", key));
    return value.get<std::string>();
}

int64_t Node::index(const char* key) const {
    if (!has(key)) return -1;
    const double value = number(key, 0);
    if (!(value >= 0 && value < 9e15) || value != std::floor(value))
        throw error(fmt::format("found {} as \"{}\", expected a whole number", value, key));
    return static_cast<int64_t>(value);
}

std::vector<double> Node::numbers(const char* key, const std::vector<double>& fallback) const {
    if (!has(key)) return fallback;
    const Json& value = (*json_)[key];
    std::vector<double> result;
    if (value.is_array())
        for (const Json& entry : value)
            if (entry.is_number()) result.push_back(entry.get<double>());
    if (!value.is_array() || result.size() != value.size() || result.size() != fallback.size())
        throw error(fmt::format("\"{}\" has to have {} numbers", key, fallback.size()));
    for (const double number : result)
        if (!std::isfinite(number)) throw error(fmt::format("\"{}\" is not finite", key));
    return result;
}

Document::Document(const fs::path& file, MemoryBudget& memory)
    : file_(file), name_(file.string()), memory_(memory) {
    MeshOptions options;
    options.memory = &memory;
    std::string text = readMeshFile(file, options);
    files_.insert(name_);
    std::string binary;
    if (text.size() >= 12 && word(text, 0) == kMagic) {
        if (word(text, 4) != 2)
            throw Error("{}: found binary glTF of version {}, expected 2", name_, word(text, 4));
        std::string json;
        for (size_t at = 12; at + 8 <= text.size();) {
            const size_t length = word(text, at);
            const uint32_t type = word(text, at + 4);
            if (length > text.size() - at - 8)
                throw Error("{}: a chunk of {} bytes is longer than the file", name_, length);
            if (type == kJsonChunk && json.empty()) json = text.substr(at + 8, length);
            if (type == kBinaryChunk && binary.empty()) binary = text.substr(at + 8, length);
            at += 8 + length;
        }
        text = std::move(json);
    }
    memory.take(text.size() * kJsonBytes + binary.size(), "the file");
    try {
        json_ = Json::parse(text);
    } catch (const Json::exception& problem) {
        throw Error("{}: is not JSON: {}", name_, problem.what());
    }
    const std::string version = root().at("asset").string("version", "");
    if (!version.starts_with("2."))
        throw Error("{}: found glTF of version \"{}\", expected 2.0", name_, version);
    const Node buffers = root().at("buffers");
    for (size_t i = 0; i < buffers.size(); ++i) {
        const Node buffer = buffers.at(i);
        if (buffer.has("uri"))
            buffers_.push_back(resource(buffer, buffer.string("uri", "")));
        else
            buffers_.push_back(i == 0 ? std::move(binary) : std::string());
        const int64_t length = buffer.index("byteLength");
        if (length > static_cast<int64_t>(buffers_.back().size()))
            throw buffer.error(fmt::format("found {} bytes, expected {}", buffers_.back().size(), length));
    }
}

std::string Document::resource(const Node& owner, const std::string& uri) const {
    if (uri.starts_with("data:")) {
        const size_t comma = uri.find(',');
        if (comma == std::string::npos || !std::string_view(uri).substr(0, comma).ends_with(";base64"))
            throw owner.error("found a \"data:\" that is not base64");
        memory_.take(uri.size(), "the data");
        return base64(owner, std::string_view(uri).substr(comma + 1));
    }
    try {
        const fs::path path = mitsuba::findFile(decoded(uri), name_, {file_.parent_path()});
        files_.insert(path.string());
        MeshOptions options;
        options.memory = &memory_;
        std::string bytes = readMeshFile(path, options);
        memory_.take(bytes.size(), "the file");
        return bytes;
    } catch (const Error& problem) {
        throw owner.error(problem.what());
    }
}

/// Bytes, and the distance of elements in them.
struct Document::View {
    std::string_view bytes;
    size_t stride = 0;  ///< 0: tightly packed
};

Document::View Document::view(size_t index) const {
    const Node node = element("bufferViews", index);
    const int64_t buffer = node.index("buffer");
    if (buffer < 0 || static_cast<size_t>(buffer) >= buffers_.size())
        throw node.error(fmt::format("found the buffer {}, but there are {}", buffer, buffers_.size()));
    const std::string& bytes = buffers_[static_cast<size_t>(buffer)];
    const auto offset = static_cast<uint64_t>(std::max<int64_t>(node.index("byteOffset"), 0)),
               length = static_cast<uint64_t>(std::max<int64_t>(node.index("byteLength"), 0));
    if (offset > bytes.size() || length > bytes.size() - offset)
        throw node.error(
            fmt::format("found {} bytes from {} on, but the buffer has {}", length, offset, bytes.size()));
    return {std::string_view(bytes).substr(offset, length),
            static_cast<size_t>(std::max<int64_t>(node.index("byteStride"), 0))};
}

/// The part of a view that an accessor names, checked against its count. Without a view: nothing.
Document::View Document::elements(const Node& accessor, size_t elementBytes) const {
    if (!accessor.has("bufferView")) return {};
    View result = view(static_cast<size_t>(accessor.index("bufferView")));
    const auto offset = static_cast<uint64_t>(std::max<int64_t>(accessor.index("byteOffset"), 0));
    const auto count = static_cast<uint64_t>(std::max<int64_t>(accessor.index("count"), 0));
    if (result.stride == 0) result.stride = elementBytes;
    if (count > 0) {
        const bool fits = offset <= result.bytes.size() && elementBytes <= result.bytes.size() - offset &&
                          count - 1 <= (result.bytes.size() - offset - elementBytes) / result.stride;
        if (!fits)
            throw accessor.error(fmt::format("found {} elements, more than the buffer view holds", count));
        result.bytes.remove_prefix(offset);
    }
    return result;
}

int Document::components(size_t accessor) const { return componentsOf(element("accessors", accessor)); }

std::vector<float> Document::floats(size_t index, int components) const {
    const Node node = element("accessors", index);
    const ComponentType& type = componentType(node);
    const auto width = static_cast<size_t>(componentsOf(node));
    if (width != static_cast<size_t>(components))
        throw node.error(fmt::format("found {} components, expected {}", width, components));
    const bool normalized = node.boolean("normalized", false) && type.most > 0;
    const size_t count = countOf(node, width * sizeof(float), memory_);
    std::vector<float> result(count * width);
    const auto read = [&](const char* bytes, float* to) {
        for (size_t c = 0; c < width; ++c) {
            const double value = type.read(bytes + c * type.bytes);
            to[c] = static_cast<float>(normalized ? std::max(value / type.most, -1.0) : value);
        }
    };
    const View plain = elements(node, width * type.bytes);
    if (!plain.bytes.empty())
        for (size_t i = 0; i < count; ++i) read(plain.bytes.data() + i * plain.stride, &result[i * width]);
    if (!node.has("sparse")) return result;

    const Node sparse = node.at("sparse"), places = sparse.at("indices");
    const ComponentType& placeType = componentType(places);
    const size_t changed = countOf(sparse, sizeof(uint32_t), memory_);
    // Neither has a count of its own.
    const auto counted = [&](Json json) {
        json["count"] = changed;
        return json;
    };
    const Json placesJson = counted(places.json()), valuesJson = counted(sparse.at("values").json());
    const View at = elements({name_, places.path(), placesJson}, placeType.bytes),
               values = elements({name_, sparse.path(), valuesJson}, width * type.bytes);
    if (at.bytes.empty() || values.bytes.empty()) return result;
    for (size_t i = 0; i < changed; ++i) {
        const double place = placeType.read(at.bytes.data() + i * at.stride);
        if (!(place >= 0 && place < static_cast<double>(count)))
            throw sparse.error(fmt::format("found the index {}, but there are {} elements", place, count));
        read(values.bytes.data() + i * values.stride, &result[static_cast<size_t>(place) * width]);
    }
    return result;
}

std::vector<uint32_t> Document::indices(size_t index) const {
    const Node node = element("accessors", index);
    const ComponentType& type = componentType(node);
    if (type.most == 0) throw node.error("found floating-point indices, expected unsigned integers");
    const size_t count = countOf(node, sizeof(uint32_t), memory_);
    const View view = elements(node, type.bytes);
    std::vector<uint32_t> result(count, 0);
    if (!view.bytes.empty())
        for (size_t i = 0; i < count; ++i)
            result[i] = static_cast<uint32_t>(type.read(view.bytes.data() + i * view.stride));
    return result;
}

ImageData Document::image(size_t index, bool raw) const {
    const Node node = element("images", index);
    try {
        if (node.has("bufferView"))
            return readImageBytes(node.path(), view(static_cast<size_t>(node.index("bufferView"))).bytes, raw,
                                  &memory_);
        const std::string uri = node.string("uri", "");
        if (uri.starts_with("data:")) return readImageBytes(node.path(), resource(node, uri), raw, &memory_);
        const fs::path path = mitsuba::findFile(decoded(uri), name_, {file_.parent_path()});
        files_.insert(path.string());
        return readImage(path, raw, &memory_);
    } catch (const Error& problem) {
        const std::string message = problem.what();
        if (message.starts_with(name_ + ":")) throw;
        throw node.error(message);
    }
}

}  // namespace metrolux::core::gltf
