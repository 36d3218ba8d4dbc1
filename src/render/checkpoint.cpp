#include "render/checkpoint.h"

#include "base/error.h"
#include "base/printable.h"
#include "base/state_archive.h"
#include "image/atomic_file.h"
#include "image/exact_sum.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <sys/stat.h>
#include <time.h>
#include <zlib.h>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

/// What the file begins with; a number for each change of the format, in the machine's order of bytes.
constexpr std::string_view kMagic = "Metrolux";
constexpr uint32_t kFormat = 4, kForeignFormat = __builtin_bswap32(kFormat);
/// Magic, format, checksum of the payload, size of the payload.
constexpr size_t kHeaderBytes = 8 + 4 + 4 + 8;

/// CRC-32 finds every flipped bit and every burst of up to 32.
uint32_t checksum(std::string_view bytes, uint32_t start = 0) {
    return static_cast<uint32_t>(
        ::crc32_z(start, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// Of a file that is here: an error of reading is no damage.
std::string readBytes(const fs::path& file) {
    std::error_code code;
    if (!fs::is_regular_file(file, code)) {
        const fs::path previous = previousCheckpoint(file);
        throw Error("checkpoint '{}': there is no such file{}", file.string(),
                    fs::exists(previous, code) ? fmt::format(", but there is '{}'", previous.string()) : "");
    }
    std::string bytes(fs::file_size(file), '\0');
    std::ifstream stream(file, std::ios::binary);
    stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!stream) throw Error("checkpoint '{}': cannot be read", file.string());
    return bytes;
}

/// The payload, after all checks that need no version.
std::string_view checkedPayload(std::string_view bytes, const std::string& name) {
    if (!bytes.starts_with(kMagic)) throw Error("'{}' is not a checkpoint of Metrolux", name);
    if (bytes.size() < kHeaderBytes)
        throw Error("checkpoint '{}' is damaged: found {} bytes, expected {} of a header", name, bytes.size(),
                    kHeaderBytes);
    StateReader reader(bytes.substr(kMagic.size(), kHeaderBytes - kMagic.size()));
    uint32_t format = 0, sum = 0;
    uint64_t size = 0;
    reader(format, sum, size);
    if (format == kForeignFormat)
        throw Error("checkpoint '{}' was written on a machine with another order of bytes", name);
    if (format != kFormat)
        throw Error("checkpoint '{}': found format {}, expected {}", name, format, kFormat);
    const std::string_view payload = bytes.substr(kHeaderBytes);
    if (payload.size() != size)
        throw Error("checkpoint '{}' is damaged: found {} bytes, expected {}", name, bytes.size(),
                    kHeaderBytes + size);
    if (const uint32_t found = checksum(payload); found != sum)
        throw Error("checkpoint '{}' is damaged: found the checksum {:08x}, expected {:08x}", name, found,
                    sum);
    return payload;
}

/// The checksum is that of a file which somebody may have made: contents are checked too.
void checkIdentity(const std::string& text) {
    // Parsing keeps a stack, but comparing and writing recurse.
    constexpr int kLevels = 8;
    const auto shallow = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
        checkState(depth <= kLevels, "an identity of fewer levels");
        return true;
    };
    const nlohmann::json identity = nlohmann::json::parse(text, shallow, false);
    checkState(!identity.is_discarded(), "an identity in JSON");
    const auto find = [&](const std::string& path) {
        const nlohmann::json::json_pointer pointer(path);
        return identity.contains(pointer) ? identity.at(pointer) : nlohmann::json();
    };
    checkState(find("/scene/name").is_string(), "the scene's name");
    checkState(find("/algorithm/integrator").is_string(), "the integrator's name");
    checkState(find("/algorithm/seed").is_number_integer(), "a seed");
    const nlohmann::json slices = find(std::string("/") + kSliceCountKey);
    const nlohmann::json exponent = find(std::string("/") + kEmissionExponentKey);
    checkState(
        exponent.is_null() || (exponent.is_number_integer() && std::abs(exponent.get<int64_t>()) < 512),
        "an exponent of the emission");
    checkState(slices.is_number_unsigned() && slices >= 1u && slices <= kMostSlices, "a number of slices");
}

/// The window lies in the image, and its film has the bytes for it, before memory is taken for it.
void checkWindow(const FilmWindow& w, size_t filmBytes) {
    const auto inside = [](int begin, int size, int full) {
        return begin >= 0 && size > 0 && size <= full && begin <= full - size;
    };
    checkState(inside(w.x, w.width, w.fullWidth) && inside(w.y, w.height, w.fullHeight),
               "a window inside of the image");
    checkState(uint64_t(w.width) * uint64_t(w.height) <= filmBytes / sizeof(PixelSum),
               "the sums of all pixels");
}

void checkContents(const Checkpoint& c) {
    checkIdentity(c.identity);
    checkWindow(c.window, c.film.size());
    for (const double x : {c.seconds, c.limits.seconds, c.limits.relativeError, c.rays.secondsInEmbree})
        checkState(std::isfinite(x) && x >= 0, "times and limits that are finite");
}

std::string fileFingerprint(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::vector<char> block(size_t{1} << 20);
    uint32_t sum = 0;
    uint64_t size = 0;
    while (stream) {
        stream.read(block.data(), static_cast<std::streamsize>(block.size()));
        const auto count = static_cast<size_t>(stream.gcount());
        sum = checksum({block.data(), count}, sum);
        size += count;
    }
    if (stream.bad() || size == 0) throw Error("{}: cannot be read again", file.string());
    return fmt::format("{} bytes, checksum {:08x}", size, sum);
}

}  // namespace

template <class Archive>
void Checkpoint::serialize(Archive& archive) {
    archive(command, folder, outputs, limits.seconds, limits.passes, limits.relativeError, identity, seconds,
            rays.intersectRays, rays.shadowRays, rays.secondsInEmbree);
    archive(window.fullWidth, window.fullHeight, window.x, window.y, window.width, window.height);
    serializeElements(archive, nonFinite, "techniques");
    archive(film, denoising, slices);
}

fs::path previousCheckpoint(const fs::path& file) { return file.string() + ".1"; }

std::string checkpointHeader(std::string_view payload) {
    StateWriter writer;
    writer.write(kMagic.data(), kMagic.size());
    writer(kFormat, checksum(payload), uint64_t{payload.size()});
    return writer.take();
}

void writeCheckpoint(const fs::path& file, const Checkpoint& checkpoint) {
    StateWriter writer;
    writer(checkpoint.version, checkpoint);
    const std::string payload = writer.take(), head = checkpointHeader(payload);
    AtomicFile target(file);
    target.write(head);
    target.write(payload);
    target.commit(previousCheckpoint(file));
}

Checkpoint parseCheckpoint(std::string_view bytes, const std::string& name, const std::string& version) {
    Checkpoint checkpoint;
    StateReader reader(checkedPayload(bytes, name));
    try {
        reader(checkpoint.version);
        // What follows may have another shape.
        if (checkpoint.version == version) {
            reader(checkpoint);
            reader.checkEnd();
            checkContents(checkpoint);
        }
    } catch (const Error& problem) {
        throw Error("checkpoint '{}' is damaged: {}", name, problem.what());
    }
    if (checkpoint.version != version)
        throw Error("checkpoint '{}' was written by version {} of Metrolux, this is {}", name,
                    checkpoint.version, version);
    return checkpoint;
}

Checkpoint readCheckpoint(const fs::path& file, const std::string& version) {
    const std::string bytes = readBytes(file);
    try {
        return parseCheckpoint(bytes, file.string(), version);
    } catch (const Error& problem) {
        std::error_code code;
        const fs::path previous = previousCheckpoint(file);
        if (!fs::exists(previous, code)) throw;
        throw Error("{}; the one before it is '{}'", problem.what(), previous.string());
    }
}

FileStamp stampOf(const fs::path& file) {
    struct stat status {};
    if (::stat(file.c_str(), &status) != 0) return {};
    return {status.st_dev, status.st_ino, static_cast<uint64_t>(status.st_size),
            int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

int64_t fileClock() {
    // Not the coarse clock: since Linux 6.13 a file that was looked at is stamped by the fine one, so that a
    // file written before could seem to be written after.
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

nlohmann::json fingerprints(const std::vector<fs::path>& files, const std::vector<FileStamp>& stamps) {
    nlohmann::json result = nlohmann::json::object();
    if (files.empty()) return result;
    const fs::path folder = fs::absolute(files.front()).parent_path();
    for (size_t i = 0; i < files.size(); ++i) {
        const std::string sum = fileFingerprint(files[i]);
        if (stamps[i].modified == 0 || stampOf(files[i]) != stamps[i])
            throw Error(
                "{}: has changed since it was read: a checkpoint would name a scene that was not rendered",
                files[i].string());
        result[validUtf8(fs::absolute(files[i]).lexically_relative(folder).generic_string())] = sum;
    }
    return result;
}

std::vector<std::string> differences(const nlohmann::json& found, const nlohmann::json& expected) {
    const nlohmann::json a = found.flatten(), b = expected.flatten();
    std::vector<std::string> result;
    const auto text = [](const nlohmann::json& object, const std::string& key) {
        return object.contains(key) ? object[key].dump() : "nothing";
    };
    for (const auto& [key, value] : a.items())
        if (!b.contains(key) || b[key] != value)
            result.push_back(fmt::format("{}: found {}, expected {}", key, value.dump(), text(b, key)));
    for (const auto& [key, value] : b.items())
        if (!a.contains(key))
            result.push_back(fmt::format("{}: found nothing, expected {}", key, value.dump()));
    return result;
}

std::vector<std::string> buildDifferences(nlohmann::json& found, nlohmann::json& expected) {
    const auto take = [](nlohmann::json& identity) {
        nlohmann::json build = identity.value(kBuildKey, nlohmann::json::object());
        identity.erase(kBuildKey);
        return build;
    };
    const nlohmann::json a = take(found), b = take(expected);
    return differences(a, b);
}

}  // namespace metrolux::core
