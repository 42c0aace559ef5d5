/* Which sources the library was built from: the build says. */
#include "kernel.h"

API const char *purcell_digest(void) { return PURCELL_DIGEST; }
