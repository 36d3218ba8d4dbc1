#pragma once
/// The file that keeps a rendering between two processes.

#include "base/state.h"
#include "geometry/intersector.h"
#include "image/film_window.h"
#include "render/pass_loop.h"
#include "render/slices.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace metrolux::core {

/// Everything that a rendering needs to go on, but for the scene's files.
struct Checkpoint {
    std::string version;               ///< of the program
    std::vector<std::string> command;  ///< words of `metrolux render ...`
    std::string folder;                ///< its working directory
    std::vector<std::string> outputs;  ///< images
    RenderLimits limits;
    /// JSON: what the passes depend on, scene files and options. Renderings of the same identity can be
    /// continued and merged.
    std::string identity;
    double seconds = 0;           ///< rendered so far
    RayStatistics rays;           ///< traced so far
    TechniqueCounts nonFinite{};  ///< Integrator::nonFinite so far
    FilmWindow window;
    std::string film;                ///< Film::saveState
    std::string denoising;           ///< saveState of a DenoisingState; empty unless the image is denoised
    std::vector<SliceState> slices;  ///< that have passes

    template <class Archive>
    void serialize(Archive& archive);
};

/// Replaces the file as a whole or not at all; the one before is kept as FILE.1. Throws Error.
void writeCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);
/// Throws Error that says what is wrong with the file: damaged, of another format or version of the program,
/// or with contents that no rendering has. What it returns has an identity that can be parsed, compared and
/// asked for scene/name, algorithm and slices, and a window that `film` has the bytes for.
Checkpoint readCheckpoint(const std::filesystem::path& file, const std::string& version);
/// As readCheckpoint(), from the file's bytes; `name` is for messages.
Checkpoint parseCheckpoint(std::string_view bytes, const std::string& name, const std::string& version);

/// What precedes the payload in a file: magic, format, checksum, size.
std::string checkpointHeader(std::string_view payload);

/// FILE.1.
std::filesystem::path previousCheckpoint(const std::filesystem::path& file);

/// Size and checksum of each file, by its name relative to the folder of the first one. `stamps`: of the
/// files as they were read, without a time where one changed meanwhile. Throws Error for a file that is not
/// that one any more: it would name a scene that was not rendered. What tells that a file is the one that it
/// was, without reading it again.
struct FileStamp {
    uint64_t device = 0, inode = 0, size = 0;
    int64_t modified = 0;  ///< nanoseconds; 0: the file is not there
    bool operator==(const FileStamp&) const = default;
};
FileStamp stampOf(const std::filesystem::path& file);
/// Now, never before the stamp of a file that has been written; a file written after it may be stamped by up
/// to a tick of the kernel (10 ms) before it.
int64_t fileClock();

nlohmann::json fingerprints(const std::vector<std::filesystem::path>& files,
                            const std::vector<FileStamp>& stamps);
/// What differs between two identities, one line for each difference; empty if they are the same.
std::vector<std::string> differences(const nlohmann::json& found, const nlohmann::json& expected);
/// Takes the builds (kBuildKey) out of two identities and tells how they differ.
std::vector<std::string> buildDifferences(nlohmann::json& found, nlohmann::json& expected);

}  // namespace metrolux::core
