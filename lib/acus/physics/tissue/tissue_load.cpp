#include "acus/physics/tissue/tissue_load.h"

#include <type_traits>

namespace acus::tissue {

// A step copies it; nothing may be allocated then.
static_assert(std::is_copy_assignable_v<TissueLoad>);

}  // namespace acus::tissue
