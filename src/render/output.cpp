#include "render/output.h"

#include "base/error.h"
#include "image/atomic_file.h"
#include "render/aov.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

std::string lowerExtension(const fs::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

/// Whether two names stand for one file, which need not exist.
bool sameFile(const fs::path& a, const fs::path& b) {
    std::error_code code;
    if (fs::equivalent(a, b, code)) return true;
    const auto canonical = [](const fs::path& file) {
        std::error_code failed;
        const fs::path absolute = fs::absolute(followLinks(file));
        fs::path result = fs::weakly_canonical(absolute, failed);
        return failed ? absolute.lexically_normal() : result;
    };
    return canonical(a) == canonical(b);
}

/// A picture that this program wrote says so. An empty file (of mktemp) is nobody's picture.
bool isForeign(const fs::path& file) {
    std::error_code code;
    if (!fs::is_regular_file(file, code) || fs::file_size(file, code) == 0) return false;
    try {
        for (const auto& [name, value] : readMetadata(file))
            if (const auto* text = std::get_if<std::string>(&value);
                text && name == "Software" && text->starts_with("Metrolux"))
                return false;
    } catch (const Error&) {
        return true;  // no picture that can be read
    }
    return true;
}

/// Writes a file that is not there yet beside or instead of `name`; returns its path.
fs::path writeBesideOthers(const fs::path& folder, const std::string& name, const std::string& bytes) {
    constexpr int kMostRescues = 1000;
    for (int i = 0; i < kMostRescues; ++i) {
        const fs::path file =
            folder / (i == 0 ? "metrolux-rescue-" + name : fmt::format("metrolux-rescue-{}-{}", i, name));
        std::error_code code;
        if (fs::exists(fs::symlink_status(file, code))) continue;
        AtomicFile target(file);
        target.write(bytes);
        if (target.commitNew()) return file;
    }
    throw Error("cannot write '{}': {} rescued images are there", (folder / name).string(), kMostRescues);
}

}  // namespace

ImagePlace placeOf(const FilmWindow& w) {
    if (w.width == w.fullWidth && w.height == w.fullHeight) return {};
    return {w.x, w.y, w.fullWidth, w.fullHeight};
}

void checkDistinct(std::span<const NamedOutput> outputs, std::span<const fs::path> inputs) {
    for (size_t i = 0; i < outputs.size(); ++i) {
        // An input is there, so an output that is the same file is there too.
        std::error_code code;
        for (const fs::path& input : inputs)
            if (fs::equivalent(outputs[i].file, input, code))
                throw Error("{} would replace '{}', which the rendering reads", outputs[i].what,
                            input.string());
        for (size_t j = 0; j < i; ++j)
            if (sameFile(outputs[i].file, outputs[j].file))
                throw Error("{} and {} are the same file", outputs[j].what, outputs[i].what);
    }
}

OutputSet::OutputSet(std::vector<fs::path> files, const Display& display, bool overwrite)
    : files_(std::move(files)), display_(display) {
    std::vector<NamedOutput> named;
    for (const fs::path& file : files_) {
        const std::string extension = lowerExtension(file);
        if (extension != ".exr" && extension != ".png")
            throw Error("output '{}': the extension is '{}', expected .exr or .png", file.string(),
                        extension);
        named.push_back({fmt::format("output '{}'", file.string()), file});
        checkWritable(file);
        if (!overwrite && isForeign(file))
            throw Error("output '{}' exists and was not written by Metrolux: --overwrite replaces it",
                        file.string());
    }
    checkDistinct(named, {});
}

bool OutputSet::isPicture(const fs::path& file) { return lowerExtension(file) == ".png"; }

std::string OutputSet::encoded(const fs::path& file, const RenderedFrame& frame) const {
    if (!isPicture(file)) return encodeExr(frame.image, frame.layers, frame.metadata);
    const auto denoised = std::find_if(frame.layers.begin(), frame.layers.end(),
                                       [](const ImageLayer& layer) { return layer.name == kDenoisedLayer; });
    if (denoised == frame.layers.end())
        return encodePng(frame.image, display_.exposure, display_.curve, frame.metadata);
    ImageData image = frame.image;
    image.pixels = denoised->pixels;
    return encodePng(image, display_.exposure, display_.curve, frame.metadata);
}

std::vector<std::string> OutputSet::write(const RenderedFrame& frame) const {
    std::vector<std::string> failures;
    for (const fs::path& file : files_) {
        try {
            writeFile(file, encoded(file, frame));
        } catch (const std::exception& error) {
            failures.emplace_back(error.what());
        }
    }
    return failures;
}

OutputSet::RescueResult OutputSet::writeOrRescue(const RenderedFrame& frame) const {
    RescueResult result;
    for (const fs::path& file : files_) {
        std::string bytes;
        try {
            bytes = encoded(file, frame);
            writeFile(file, bytes);
            continue;
        } catch (const std::exception& error) {
            result.failures.emplace_back(error.what());
        }
        if (bytes.empty()) continue;
        std::error_code code;
        for (const fs::path& folder : {fs::path("."), fs::temp_directory_path(code)}) {
            try {
                result.rescued.push_back(writeBesideOthers(folder, file.filename().string(), bytes));
                break;
            } catch (const std::exception& error) {
                result.failures.emplace_back(error.what());
            }
        }
    }
    return result;
}

}  // namespace metrolux::core
