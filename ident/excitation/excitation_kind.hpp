// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <variant>

#include "ident/excitation/chirp.hpp"
#include "ident/excitation/gaussian.hpp"
#include "ident/excitation/multisine.hpp"
#include "ident/excitation/odd_random_multisine.hpp"
#include "ident/excitation/prms.hpp"
#include "ident/excitation/sine.hpp"
#include "ident/excitation/step.hpp"
#include "ident/excitation/table_excitation.hpp"

namespace eha::ident {

/// Every kind of excitation that an experiment file can name; excitation.hpp lists what each must provide.
using ExcitationKind = std::variant<Multisine, OddRandomMultisine, Prms, Chirp, Gaussian, Step, Sine, Table>;

}  // namespace eha::ident
