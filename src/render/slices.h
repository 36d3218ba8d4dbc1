#pragma once
/// A rendering divided into independent slices of passes, which need each other only when their films are
/// summed.

#include "image/half_sums.h"
#include "integrators/integrator.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace metrolux::core {

/// That a rendering may be divided into.
inline constexpr uint32_t kMostSlices = 1 << 20;

/// The number of slices in the identity of a checkpoint: the name that the format has for it.
inline constexpr const char* kSliceCountKey = "streams";
/// buildIdentity(), of a checkpoint.
inline constexpr const char* kBuildKey = "build";
/// Whether the halves of the passes are kept, there if they are.
inline constexpr const char* kHalvesKey = "halves";
/// Film::exponent(), there unless it is 0.
inline constexpr const char* kEmissionExponentKey = "emission_exponent";

/// Pass p of a rendering belongs to slice p mod `count`. Of these, a process may render `first` ... `last`.
struct SliceChoice {
    uint32_t count = 1, first = 0, last = 0;
};

/// Seed of a slice; a single one has the rendering's own.
uint64_t sliceSeed(uint64_t seed, uint32_t slice, uint32_t count);
/// Passes of a slice in a rendering of so many.
uint32_t passesOfSlice(uint32_t slice, uint32_t count, uint32_t passes);
/// Passes of all chosen slices in a rendering of so many. Throws Error when there are none.
uint32_t passesOfChoice(const SliceChoice& choice, uint32_t passes);

/// A slice between two of its passes.
struct SliceState {
    uint32_t index = 0, passes = 0;
    std::string integrator;  ///< Integrator::saveState
    template <class Archive>
    void serialize(Archive& archive) {
        archive(index, passes, integrator);
    }
};

/// Renders slices as one integrator. One of them is alive at a time, the others wait as SliceStates: memory
/// is that of one integrator. With a number of passes, a slice is rendered to its end before the next one
/// begins; without, slices take turns after every kTurn passes.
class SlicedIntegrator final : public Integrator {
  public:
    /// Makes the integrator of a slice, before its first pass.
    using Make = std::function<std::unique_ptr<Integrator>(uint32_t slice)>;
    /// The next slice to begin or to go on with; nothing when all are done or others have them.
    using Next = std::function<std::optional<uint32_t>()>;
    static constexpr uint32_t kTurn = 8;

    SlicedIntegrator(Make make, const SliceChoice& choice, uint32_t totalPasses = 0);

    /// Of the rendering, all slices together; 0: no limit.
    void setTotalPasses(uint32_t passes) { totalPasses_ = passes; }

    /// Keeps apart two halves of the passes, too. A half has whole passes of a slice: it is the same however
    /// slices are divided.
    void keepHalves(std::shared_ptr<HalfSums> halves) { halves_ = std::move(halves); }

    /// In place of the order of slices (ranks of MPI share them).
    void setNext(Next next) { next_ = std::move(next); }
    /// Whether the slice has passes left.
    bool unfinished(uint32_t slice) const;
    /// Chooses the slice of the next pass; false when none is left.
    bool advance();

    /// Adds the next pass of a slice, whose own number names its random numbers: that of the whole is
    /// unused.
    void addPass(Film& film, uint32_t pass) override;
    TechniqueCounts nonFinite() const override;
    nlohmann::json statistics() const override;
    std::string progressNote() const override;

    /// Slices that have passes, in ascending order; all, or those that this process has rendered.
    std::vector<SliceState> states(bool ownOnly = false) const;
    /// Before the first pass. Throws Error for slices that are not chosen.
    void restore(std::vector<SliceState> states);
    void saveState(StateWriter& writer) const override;
    void loadState(StateReader& reader) override;

  private:
    struct Slice {
        uint32_t passes = 0;
        bool own = false;   ///< rendered here
        std::string state;  ///< while it is not alive
    };
    std::optional<uint32_t> nextInOrder() const;
    void wake(uint32_t slice);
    Slice& at(uint32_t slice) { return slices_[slice - choice_.first]; }
    const Slice& at(uint32_t slice) const { return slices_[slice - choice_.first]; }

    Make make_;
    Next next_;
    std::shared_ptr<HalfSums> halves_;  ///< null: not kept
    SliceChoice choice_;
    uint32_t totalPasses_, turn_ = 0;
    std::vector<Slice> slices_;
    std::optional<uint32_t> alive_;
    std::unique_ptr<Integrator> integrator_;
    TechniqueCounts nonFiniteOfOthers_{};  ///< of integrators that are no longer alive
};

}  // namespace metrolux::core
