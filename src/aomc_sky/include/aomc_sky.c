/* The functions of aomc_sky.h as external ones, for Fortran, hosts under -Ofast and others: compile this file with the
 * program, without -ffast-math. */
#undef AOMC_SKY_DECLARE_ONLY
#define AOMC_SKY_API
#define AOMC_SKY_HOST_API
#include "aomc_sky.h"

typedef char aomc_sky_source_has_512_bytes[sizeof(void *) != 8 || sizeof(aomc_sky_source) == 512 ? 1 : -1];
typedef char aomc_sky_stream_has_2064_words[sizeof(void *) != 8 || sizeof(aomc_sky_stream) == 8 * 2064 ? 1 : -1];
