#include "render/output.h"

#include "base/error.h"
#include "image/atomic_file.h"

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

}  // namespace

OutputSet::OutputSet(std::vector<fs::path> files, const Display& display)
    : files_(std::move(files)), display_(display) {
    for (size_t i = 0; i < files_.size(); ++i) {
        const std::string extension = lowerExtension(files_[i]);
        if (extension != ".exr" && extension != ".png")
            throw Error("output '{}': the extension is '{}', expected .exr or .png", files_[i].string(),
                        extension);
        if (std::find(files_.begin(), files_.begin() + static_cast<std::ptrdiff_t>(i), files_[i]) !=
            files_.begin() + static_cast<std::ptrdiff_t>(i))
            throw Error("output '{}' is named twice", files_[i].string());
        checkWritable(files_[i]);
    }
}

void OutputSet::writeOne(const fs::path& file, const RenderedFrame& frame) const {
    if (lowerExtension(file) == ".exr")
        writeExr(file, frame.image, frame.layers, frame.metadata);
    else
        writePng(file, frame.image, display_.exposure, display_.curve);
}

std::vector<std::string> OutputSet::write(const RenderedFrame& frame) const {
    std::vector<std::string> failures;
    for (const fs::path& file : files_) {
        try {
            writeOne(file, frame);
        } catch (const std::exception& error) {
            failures.emplace_back(error.what());
        }
    }
    return failures;
}

OutputSet::RescueResult OutputSet::writeOrRescue(const RenderedFrame& frame) const {
    RescueResult result;
    for (const fs::path& file : files_) {
        try {
            writeOne(file, frame);
            continue;
        } catch (const std::exception& error) {
            result.failures.emplace_back(error.what());
        }
        std::error_code code;
        for (const fs::path& folder : {fs::path("."), fs::temp_directory_path(code)}) {
            const fs::path rescue = folder / ("metrolux-rescue-" + file.filename().string());
            try {
                writeOne(rescue, frame);
                result.rescued.push_back(rescue);
                break;
            } catch (const std::exception& error) {
                result.failures.emplace_back(error.what());
            }
        }
    }
    return result;
}

}  // namespace metrolux::core
