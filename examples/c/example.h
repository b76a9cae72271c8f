/* What the examples share, beside aomc_sky.h: the end after an error, and one number that holds the bits of all photons. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "aomc_sky.h"

#define BLOCK 65536

/* Give the code back; a negative one ends the program with what it says. */
static inline int64_t need(int64_t code)
{
    if (code >= 0) return code;
    fprintf(stderr, "aomc-sky: %s\n", aomc_sky_message(code));
    exit(1);
}

/* The bits of photon i, turned by its index. The exclusive or of all photons of a band is the same number for any number
 * of threads and ranks, and in Python; a host has no need of it. */
#ifdef __CUDACC__
__host__ __device__
#endif
static inline uint64_t bits_of(int64_t i, float ux, float uy, float uz)
{
    uint32_t x, y, z;
    memcpy(&x, &ux, 4);
    memcpy(&y, &uy, 4);
    memcpy(&z, &uz, 4);
    const int k = (int)(i % 63) + 1;
    const uint64_t word = x ^ (uint64_t)y << 16 ^ (uint64_t)z << 32;
    return word << k | word >> (64 - k);
}

static inline void report(double nm, int64_t n, double cosine, uint64_t bits)
{
    printf("%8g nm %12lld photons, mean cosine %.6f, bits %016llx\n", nm, (long long)n, n ? cosine / (double)n : 0.0,
           (unsigned long long)bits);
}
