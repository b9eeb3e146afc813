#include "loops.h"

/* Raised with each change of a function or its arguments; `library.VERSION` says the same. */
LOOP const int32_t loops_version = 2;
