#pragma once
#include <metrolux/defaults.h>
#include <metrolux/image.h>
#include <metrolux/scene.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace metrolux {

/// A string is read as what the parameter is, so that "0.5" may stand for a number.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;
/// Values by name.
using Parameters = std::map<std::string, ParameterValue>;

struct ParameterDescription {
    std::string name, help;
    ParameterValue defaultValue;
    std::string defaultText;           ///< for people: "0.75", or "0: from the pixel size"
    std::string expected;              ///< "a number from 0 to 1"
    std::vector<std::string> choices;  ///< all values, where a text is one of a few
    double least, most;                ///< of numbers
};

struct IntegratorDescription {
    std::string name, summary;
    std::vector<ParameterDescription> parameters;
};

/// All integrators; the first is the default.
METROLUX_API std::vector<IntegratorDescription> integrators();

/// A rendering divided into independent slices of passes, of which this process renders some: their
/// checkpoints can be merged.
struct Slices {
    std::uint32_t count = 1, first = 0;
    std::optional<std::uint32_t> last;  ///< default: the last of all
};

/// What the image depends on, besides the scene and the number of passes. The number of threads is not of
/// that kind: any gives the same bits.
struct SessionOptions {
    std::string integrator =
        kDefaultIntegrator;  ///< a name of integrators(), or "scene" for what the scene names
    Parameters parameters;   ///< of the integrator
    std::uint64_t seed = 0;
    std::optional<int> maxDepth;  ///< path edges, in place of the scene's limit; -1: no limit
    std::uint64_t memory =
        kDefaultMemory;               ///< bytes that an iteration may store; more of them a pass for less
    std::vector<std::string> layers;  ///< names of docs/reference/layers.md
    Slices slices;
    int threads = 0;  ///< 0: one for each core
};

/// When to stop; the first that is reached counts. Zero: no such limit. Passes and seconds of earlier runs of
/// the session, and of the checkpoint that it went on from, count too.
struct Limits {
    double seconds = 0;  ///< of rendering
    std::uint32_t passes = 0;
    double relativeError = 0;  ///< estimated root of the mean squared relative error of the image
    bool any() const { return seconds > 0 || passes > 0 || relativeError > 0; }
};

/// What is known after a pass.
struct Progress {
    std::uint32_t passes = 0;
    double seconds = 0;
    double relativeError = std::numeric_limits<double>::infinity();  ///< infinity before it is known
    double secondsRemaining = -1;  ///< until a limit is reached, an estimate; negative when unknown
    double raysPerSecond = 0;      ///< of the process: sessions that render at once count each other's rays
    std::string note;              ///< of the integrator, for people
};

/// Files that render() writes.
struct Files {
    std::vector<std::filesystem::path> images;  ///< .exr with layers and metadata, .png through `display`
    Display display;
    bool overwrite = false;  ///< images that another program wrote, too; Metrolux's own are always replaced
    double saveEvery =
        kDefaultSaveEvery;             ///< seconds between images of what is there so far; 0: only at the end
    std::filesystem::path checkpoint;  ///< empty: none. The last two are kept, FILE and FILE.1
    double checkpointEvery = kDefaultCheckpointEvery;  ///< seconds; the last is written at the end
    /// Words of a `metrolux render ...` that stands for this rendering, so that `metrolux resume` can go on
    /// from the checkpoints in the working directory of this call. Empty: only a Session can.
    std::vector<std::string> command;
};

/// Both are called between passes by the thread that renders.
struct Hooks {
    std::function<void(const Progress&)> progress;
    std::function<bool()> stop;  ///< true ends the rendering, as Session::requestStop()
};

/// Full: a rendering has at most 16,777,215 passes.
enum class StopReason { Time, Passes, Error, Interrupted, Full };

/// What became of a rendering.
struct Outcome {
    StopReason reason = StopReason::Interrupted;
    std::uint32_t passes = 0;           ///< 0: stopped before there was an image, no file was written
    std::vector<std::string> failures;  ///< for each image that could not be written
    std::vector<std::filesystem::path> rescued;  ///< written in place of these
    std::string checkpointFailure;               ///< empty: the last checkpoint is there, or none was wanted
};

/// What a session leaves: pixels that are nobody else's.
struct Picture {
    Image image;                          ///< (height, width, 3), linear Rec.709
    std::map<std::string, Image> layers;  ///< that SessionOptions::layers names
};

/// A rendering in progress. It owns its scene. Views of pixels stay where they are as long as the session
/// lives; what they show is that of the call, until the next pass.
class METROLUX_API Session {
  public:
    /// Throws Error for names and values that are unknown, and what the integrator refuses.
    explicit Session(Scene scene, SessionOptions options = {});
    ~Session();
    Session(Session&&) noexcept;
    Session& operator=(Session&&) noexcept;

    /// Renders one pass.
    Progress step();
    /// Renders until a limit is reached or a stop is requested, which ends the pass in progress first, and
    /// writes the files. Without a limit: kDefaultSeconds. May be called again with further limits.
    /// Throws Error when a file could not be written, before any work is done.
    Outcome render(const Limits& limits, const Hooks& hooks = {}, const Files& files = {});
    /// Ends the render() in progress after its pass, or the next one before its first. Any thread may call
    /// it, and a signal handler.
    void requestStop() noexcept;

    // What is there so far; without a pass, black.
    Progress progress() const;
    /// (height, width, 3), linear Rec.709.
    ImageView image();
    /// Variance of the mean of each pixel's luminance, (height, width, 1). Too small where an integrator's
    /// passes are correlated, as those of chains are: Progress::relativeError holds there too.
    ImageView variance();
    /// (height, width, channels) of one that SessionOptions::layers names. Throws Error for another.
    ImageView layer(const std::string& name);
    /// Ends the session and hands over its buffers; nothing is copied, and no view of them remains.
    Picture finish() &&;
    /// JSON.
    std::string statistics() const;
    const Scene& scene() const;
    const SessionOptions& options() const;
    /// The name that options().integrator stands for.
    const std::string& integrator() const;
    int threads() const;

    /// .exr with layers and metadata, or .png through `display`. Throws Error.
    void saveImage(const std::filesystem::path& file, const Display& display = {});
    /// The whole state. Throws Error.
    void save(const std::filesystem::path& checkpoint) const;
    /// Before the first pass: goes on from a checkpoint of the same scene and options, bit for bit. Throws
    /// Error that says what differs.
    /// `otherBuild`: one that another build of the library or another kind of machine has written too, whose
    /// last bits could differ.
    void resume(const std::filesystem::path& checkpoint, bool otherBuild = false);

    struct Impl;

  private:
    friend struct Internals;
    std::unique_ptr<Impl> impl_;
};

/// Joins checkpoints of slices that were rendered apart and writes the image: to the bit that of one process
/// which renders them all. `layers`: of variance and denoised. Slices that are missing are warned of. Throws
/// Error for parts that overlap or belong to different renderings.
struct Merged {
    Outcome outcome;
    std::string statistics;  ///< JSON
};
METROLUX_API Merged merge(const std::vector<std::filesystem::path>& parts, const Files& files,
                          const std::vector<std::string>& layers = {});

}  // namespace metrolux
