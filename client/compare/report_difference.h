#pragma once

#include "proto/json.h"

namespace rivage::client {

/// The options that differ between two reports: `[{name, a, b}]` in the order of A, null where a
/// report does not have one.
[[nodiscard]] proto::Json optionsThatDiffer(const proto::Json& reportA, const proto::Json& reportB);

/// The energies by term before and after: `{a, b}`, null where a report has none.
[[nodiscard]] proto::Json energiesOf(const proto::Json& reportA, const proto::Json& reportB);

/// What a reader should know before trusting the figures: other grids, other places.
[[nodiscard]] proto::Json notesOn(const proto::Json& reportA, const proto::Json& reportB);

}  // namespace rivage::client
