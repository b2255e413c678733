#pragma once

/// The switch of the planted faults: number of the one that acts, in the order of catalogue.json; -1: none.
namespace concord::faults {

inline int planted = -1;

inline bool is_planted(int fault) { return fault == planted; }

}  // namespace concord::faults
