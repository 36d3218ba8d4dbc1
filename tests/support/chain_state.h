#pragma once
#include "markov/chain.h"

namespace metrolux::core::test {

/// Evaluates the state of a chain from the primary sample that a test has put there.
template <class Chain, class Evaluate>
void evaluateState(Chain& chain, Evaluate&& evaluate, CounterRng& rng) {
    PrimarySampleStream stream(chain.state().u, rng);
    evaluate(stream, chain.state().value);
}

}  // namespace metrolux::core::test
