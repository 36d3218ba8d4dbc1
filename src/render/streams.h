#pragma once
/// A rendering divided into independent streams of passes, which need each other only when their films are
/// summed.

#include "integrators/integrator.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace metrolux::core {

/// That a rendering may be divided into.
inline constexpr uint32_t kMostStreams = 1 << 20;

/// Pass p of a rendering belongs to stream p mod `count`. Of these, a process may render `first` ... `last`.
struct StreamChoice {
    uint32_t count = 1, first = 0, last = 0;
};

/// Seed of a stream; a single one has the rendering's own.
uint64_t streamSeed(uint64_t seed, uint32_t stream, uint32_t count);
/// Passes of a stream in a rendering of so many.
uint32_t passesOfStream(uint32_t stream, uint32_t count, uint32_t passes);
/// Passes of all chosen streams in a rendering of so many. Throws Error when there are none.
uint32_t passesOfChoice(const StreamChoice& choice, uint32_t passes);

/// A stream between two of its passes.
struct StreamState {
    uint32_t index = 0, passes = 0;
    std::string integrator;  ///< Integrator::saveState
    template <class Archive>
    void serialize(Archive& archive) {
        archive(index, passes, integrator);
    }
};

/// Renders streams as one integrator. One of them is alive at a time, the others wait as StreamStates: memory
/// is that of one integrator. With a number of passes, a stream is rendered to its end before the next one
/// begins; without, streams take turns after every kTurn passes.
class StreamedIntegrator final : public Integrator {
  public:
    /// Makes the integrator of a stream, before its first pass.
    using Make = std::function<std::unique_ptr<Integrator>(uint32_t stream)>;
    /// The next stream to begin or to go on with; nothing when all are done or others have them.
    using Next = std::function<std::optional<uint32_t>()>;
    static constexpr uint32_t kTurn = 8;

    StreamedIntegrator(Make make, const StreamChoice& choice, uint32_t totalPasses = 0);

    /// Of the rendering, all streams together; 0: no limit.
    void setTotalPasses(uint32_t passes) { totalPasses_ = passes; }

    /// In place of the order of streams (ranks of MPI share them).
    void setNext(Next next) { next_ = std::move(next); }
    /// Whether the stream has passes left.
    bool unfinished(uint32_t stream) const;
    /// Chooses the stream of the next pass; false when none is left.
    bool advance();

    /// Adds the next pass of a stream, whose own number names its random numbers: that of the whole is
    /// unused.
    void addPass(Film& film, uint32_t pass) override;
    TechniqueCounts nonFinite() const override;
    nlohmann::json statistics() const override;
    std::string progressNote() const override;

    /// Streams that have passes, in ascending order; all, or those that this process has rendered.
    std::vector<StreamState> states(bool ownOnly = false) const;
    /// Before the first pass. Throws Error for streams that are not chosen.
    void restore(std::vector<StreamState> states);
    void saveState(StateWriter& writer) const override;
    void loadState(StateReader& reader) override;

  private:
    struct Stream {
        uint32_t passes = 0;
        bool own = false;   ///< rendered here
        std::string state;  ///< while it is not alive
    };
    std::optional<uint32_t> nextInOrder() const;
    void wake(uint32_t stream);
    Stream& at(uint32_t stream) { return streams_[stream - choice_.first]; }
    const Stream& at(uint32_t stream) const { return streams_[stream - choice_.first]; }

    Make make_;
    Next next_;
    StreamChoice choice_;
    uint32_t totalPasses_, turn_ = 0;
    std::vector<Stream> streams_;
    std::optional<uint32_t> alive_;
    std::unique_ptr<Integrator> integrator_;
    TechniqueCounts nonFiniteOfOthers_{};  ///< of integrators that are no longer alive
};

}  // namespace metrolux::core
