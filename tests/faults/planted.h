#pragma once

/// The switches of the planted faults: numbers in the order of catalogue.json, -1: none.
namespace concord::faults {

/// The fault that acts.
inline int planted = -1;

/// A second one, of a solver: by it a fault of the comparator shows, who then misjudges it.
inline int accomplice = -1;

inline bool is_planted(int fault) { return fault == planted || fault == accomplice; }

}  // namespace concord::faults
