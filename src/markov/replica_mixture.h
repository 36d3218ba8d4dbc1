#pragma once

namespace metrolux::core {

/// Samples of each replica in an iteration, and the balance heuristic across replicas: W(u) of
/// docs/explain/algorithm.md section 3.
///
/// A chain's steps are correlated and count for less than independent samples: with statistical inefficiency
/// g, n steps of a chain enter every weight as n/g samples. Any g is unbiased.
struct ReplicaMixture {
    double uniform = 0, visibility = 0, contribution = 0;  ///< n_U, n_V, n_F
    double bVisibility = 1, bContribution = 1;
    double inefficiency = 1;  ///< g
    /// b_V and b_F as the pool of start states has them over those above. With chains that start from a state
    /// of the pool, chosen in proportion to the target, E[mean of the target over the pool * h(state)] is the
    /// integral of target * h for any h: weights with these factors have no start-up bias [Veach & Guibas
    /// 1997, section 5.1], and errors of b_V and b_F cost efficiency only. 1 for chains in equilibrium with
    /// exact normalizations.
    double visibilityScale = 1, contributionScale = 1;
    /// Weight of an invisible uniform sample: 0 where what is invisible contributes nothing, 1 / n_U where it
    /// may (no other replica makes it).
    double invisibleWeight = 0;

    double samples() const { return uniform + visibility + contribution; }
    /// Weight of a uniform sample of this size F: 1 / (n_U + n_V / (g b_V) + n_F F / (g b_F)); 0 if it is
    /// invisible.
    double uniformWeight(double size) const {
        if (!(size > 0)) return 0;
        return 1.0 /
               (uniform + (visibility / bVisibility + contribution * size / bContribution) / inefficiency);
    }
    /// Weights of a step of either chain at a state of this size.
    double visibilityWeight(double size) const {
        return uniformWeight(size) * visibilityScale / inefficiency;
    }
    double contributionWeight(double size) const {
        return uniformWeight(size) * contributionScale / inefficiency;
    }
    /// Density boost q of section 1: the visibility replica's density stands for both chains.
    double boost() const {
        const double chains = visibility + contribution;
        return (uniform + (chains > 0 ? chains / (inefficiency * bVisibility) : 0)) / samples();
    }
};

}  // namespace metrolux::core
