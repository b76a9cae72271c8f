/* The photons of aomc-sky from a file, without Python: C99, C++11 and CUDA. MIT licence.
 *
 * A file (`aomc-sky run --format source`, `sky.write_source(source, path)`) holds the plan of a source: which photon
 * falls into which cell, and what a cell is. Photon i of a band is a pure function of the file and i, with the bits
 * that the Python package gives. Functions have no state: any number of threads and ranks ask for any photons.
 *
 *     aomc_sky_file file;
 *     aomc_sky_source source;
 *     int code = aomc_sky_load("day.sky", &file);
 *     if (code == 0) code = aomc_sky_band(&file, 0, &source);
 *     if (code != 0) puts(aomc_sky_message(code));
 *     int64_t n = aomc_sky_fill(&source, 0, 65536, ux, uy, uz);
 *     aomc_sky_photon p = aomc_sky_at(&source, i);
 *     aomc_sky_unload(&file);
 *
 * Where photons have weights (a bias, which shares them out otherwise than light), aomc_sky_band answers with a code.
 * A host that counts weights opens with aomc_sky_weighted_band, and takes aomc_sky_fill_weighted, or
 * aomc_sky_weight(&source, p). A file with replicates is opened replicate by replicate, with aomc_sky_replicate.
 *
 * All bands in one go, each photon with its light, patch, component and position:
 *
 *     aomc_sky_stream stream;
 *     aomc_sky_particle p;
 *     int code = aomc_sky_particles(&stream, sources, n_sources, 0, INT64_MAX);
 *     while (code >= 0 && (code = aomc_sky_next(&stream, &p)) > 0) follow(&p);
 *
 * Directions are unit vectors of travel, z up: uz <= 0. Link with -lm. Copy this one file, and keep its name, because
 * it includes itself: once for float32, once for float64. `fill` is fast with -O2 -march=native.
 *
 * Bits depend on arithmetic as IEEE 754 has it: every operation rounded once. Compilers that contract a product and a
 * sum, or fast math, give other photons. The file therefore holds witnesses, photons that are known, and `load` tries
 * them. Code of your own translation unit may differ: aomc_sky_witness(&source) tries them there. For a GPU compile
 * with -fmad=false (nvcc), and call aomc_sky_witness once in a kernel.
 *
 * A host under -ffast-math or -Ofast writes #define AOMC_SKY_DECLARE_ONLY before it includes this file, compiles
 * aomc_sky.c without that flag, and links the two.
 *
 * Functions stand in the order of the kernels of the package, whose Python names are in the comments. */
#ifndef AOMC_SKY_PRECISION
#ifndef AOMC_SKY_H
#define AOMC_SKY_H

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "aomc_sky.h needs a little-endian machine"
#endif
#if !defined(AOMC_SKY_DECLARE_ONLY) && defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "aomc_sky.h needs floats that are computed as floats (FLT_EVAL_METHOD 0): on 32-bit x86 add -msse2 -mfpmath=sse"
#endif

/* Vectors of roots, and pointers to memory that no other one leads to. */
#if defined(__CUDACC__) || defined(__HIPCC__)
#define SKY_ALONE
#elif defined(__AVX__)
#include <immintrin.h>
#define SKY_AVX
#if defined(__AVX2__)
#define SKY_AVX2
#endif
#elif defined(__SSE2__)
#include <emmintrin.h>
#define SKY_SSE2
#elif defined(__ARM_NEON) && defined(__aarch64__)
#include <arm_neon.h>
#define SKY_NEON
#endif
#ifndef SKY_ALONE
#if defined(__GNUC__) || defined(_MSC_VER)
#define SKY_ALONE __restrict
#else
#define SKY_ALONE
#endif
#endif

/* Functions: a formula, which loops need inlined; a part of ours; one that would take registers from others if it were
 * inlined, such as the steps of a block; one for hosts; one for hosts, but for no GPU. */
#if defined(__CUDACC__) || defined(__HIPCC__)
#define SKY_FORMULA static __host__ __device__ inline
#define SKY_FN static __host__ __device__ inline
#elif defined(__GNUC__)
#define SKY_FORMULA static inline __attribute__((always_inline))
#define SKY_FN static inline
#define SKY_APART static __attribute__((noinline, unused))
#else
#define SKY_FORMULA static inline
#define SKY_FN static inline
#endif
#ifndef SKY_APART
#define SKY_APART SKY_FN
#endif
/* Memory of columns: whole lines of a cache, which no vector then crosses. */
#if defined(__GNUC__) && !defined(__CUDACC__) && !defined(__HIPCC__)
#define SKY_LINES __attribute__((aligned(64)))
#else
#define SKY_LINES
#endif
#define SKY_HOST static inline
#ifdef AOMC_SKY_DECLARE_ONLY
#define AOMC_SKY_API extern
#define AOMC_SKY_HOST_API extern
#elif !defined(AOMC_SKY_API)
#define AOMC_SKY_API SKY_FN
#define AOMC_SKY_HOST_API SKY_HOST
#if defined(__GNUC__) && !defined(__CUDACC__) && !defined(__HIPCC__)
#define SKY_NEXT SKY_FORMULA
#endif
#endif
#ifndef SKY_NEXT
#define SKY_NEXT AOMC_SKY_HOST_API
#endif
#if defined(__CUDA_ARCH__) || defined(__HIP_DEVICE_COMPILE__)
#define SKY_ON_DEVICE
#endif

/* No contraction. GCC may contract even so where it makes vectors of straight code, so that is forbidden, too.
 * Functions under GCC's pragma are not inlined into others, which keeps the flags of a host away from them. */
#if !defined(AOMC_SKY_FLAGS_OF_HOST) && !defined(AOMC_SKY_DECLARE_ONLY)
#if defined(__clang__)
#pragma clang fp contract(off)
#elif defined(__CUDACC__)
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off", "no-tree-slp-vectorize", "tree-loop-vectorize", "vect-cost-model=dynamic")
#elif defined(_MSC_VER) /* not tried by us, with /fp:precise */
#pragma fp_contract(off)
#else
#pragma STDC FP_CONTRACT OFF
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define AOMC_SKY_LAYOUT 1
#define AOMC_SKY_STREAM "aomc-sky/4"

enum {
    AOMC_SKY_NO_FILE = -1,     /* the file cannot be read */
    AOMC_SKY_NO_MEMORY = -2,   /* no memory for the file */
    AOMC_SKY_NULL = -3,        /* a pointer is NULL, or not aligned to 8 bytes */
    AOMC_SKY_NOT_OURS = -4,    /* it does not begin as such a file does */
    AOMC_SKY_NEWER = -5,       /* its layout, or a section that it needs, is newer than this header */
    AOMC_SKY_STREAMS = -6,     /* other photons than this header gives: made by another version */
    AOMC_SKY_SIZE = -7,        /* it is cut off, or longer than it says */
    AOMC_SKY_CHECKSUM = -8,    /* a byte was changed */
    AOMC_SKY_DIRECTORY = -9,   /* a section lies outside of the file, or has another length than it should */
    AOMC_SKY_TABLE = -10,      /* a number of a table is out of its bounds */
    AOMC_SKY_ARITHMETIC = -11, /* this compiler, its flags or the rounding mode give other bits */
    AOMC_SKY_NO_BAND = -12,    /* there is no such band */
    AOMC_SKY_OTHER = -13,      /* a source of the other precision */
    AOMC_SKY_RANGE = -14,      /* start or n is negative */
    AOMC_SKY_TRIALS = -15,     /* photons are refused again and again: the file is not one of ours */
    AOMC_SKY_WEIGHTS = -16,    /* photons have weights: aomc_sky_weighted_band opens the band */
    AOMC_SKY_UNITS = -17,      /* of the bands of a stream some have an irradiance and others have none */
    AOMC_SKY_REPLICATES = -18  /* a band has replicates: aomc_sky_replicate opens one */
};

typedef struct aomc_sky_file {
    const unsigned char *bytes;
    uint64_t size;
    int32_t n_bands;
    int32_t precision;    /* bytes of a float: 4 or 8 */
    char plan_sha256[65]; /* name of the plan, text */
    char is_owned;        /* whether `unload` frees the bytes */
    char reserve[2];
    int32_t n_replicates; /* independent runs that share the photons of each band */
} aomc_sky_file;

/* The photons of a band. Its pointers lead into the bytes of the file, which must not change. */
typedef struct aomc_sky_source {
    int64_t n; /* photons */
    double wavelength_nm;
    double irradiance_W_m2_nm; /* of a horizontal plane, all components; NaN where it is relative */
    const float *stokes;       /* Q/I and U/I of patch p: stokes[2 * p] and the next one; NULL: not polarised */
    double photon_light;       /* of a photon of weight 1: irradiance over photons of all replicates [W m-2 nm-1], or 1 */
    /* what follows is ours */
    int32_t precision, is_shuffled, is_short, by_philox, law_of_all, has_wide_ranks, azimuth_kernel, is_common;
    int32_t n_slot, n_cell, lobe_ends[2], n_witness, disc_cell; /* a disc, if all other cells have `law_of_all`; else -1 */
    uint64_t order_bits, order_size, order_keys[3];
    uint64_t shifts[2], steps[2], placement_key, position_key, band, guide_shift;
    uint64_t accept[3], number_shifts[3], number_steps[3]; /* of the net: keys; the first step is that of the ranks */
    const void *cumulative;      /* photons before each slot, uint32 or uint64, and two sentinels */
    const uint32_t *guide;       /* the slot of every 2^guide_shift-th rank */
    const int32_t *cell_of_slot; /* NULL where they are the same */
    const uint64_t *place;       /* of a cell: where its head and tail stand in `words` */
    const uint64_t *words;       /* heads (h0, h1, h2, ring offset) and tails (t0, t1, h3, 0) */
    const int8_t *law;           /* of a cell, before rejection and lobes; NULL where all have `law_of_all` */
    const uint64_t *slopes;      /* NULL, or slopes of a cell, 32 bits each */
    const uint32_t *perez_word;  /* NULL, or tilts and limit of a cell */
    const double *perez_bound, *sky;
    const int32_t *lobe; /* NULL, or the lobe of a cell, -1 for none */
    const uint64_t *ranges, *bin_proposals;
    const uint32_t *bins;
    const double *shapes, *envelopes, *bins_per_photon;
    const uint64_t *witnesses;
    uint64_t by_net;
    const void *weights; /* NULL, or the weight of a cell, in the precision of the source */
    const int32_t *component_ends;
    uint64_t n_component; /* 0: an older file */
    uint64_t footprint;   /* AOMC_SKY_POINT and following */
    double footprint_m[2];
    uint64_t weight_has_mu; /* the weight of photons that are launched by solid angle: that of the cell times mu */
    uint64_t reserve[4];    /* 512 bytes in all, as aomc_sky.f90 says */
} aomc_sky_source;

/* `patch` is the cell over all components, as in counts.csv. */
typedef struct aomc_sky_photon {
    float ux, uy, uz;
    int32_t patch;
} aomc_sky_photon;

typedef struct aomc_sky_photon_double {
    double ux, uy, uz;
    int32_t patch;
} aomc_sky_photon_double;

/* A photon of a stream. `weight` is its light: its weight times `photon_light` of its band. */
typedef struct aomc_sky_particle {
    double ux, uy, uz;
    double weight; /* [W m-2 nm-1], or the weight alone where light is relative */
    double x, y;   /* position [m] */
    int64_t index; /* of the photon in its band */
    int32_t band;  /* number of its source in those of the stream */
    int32_t patch, component, reserve;
} aomc_sky_particle;

enum { AOMC_SKY_BUFFER = 256 };

/* Where a stream is. It has memory of its own, so each thread has one. */
typedef struct aomc_sky_stream {
    int64_t n;  /* particles of the whole stream */
    int64_t at; /* place of the next one in it */
    int64_t to; /* where this stream ends */
    /* what follows is ours */
    const aomc_sky_source *sources;
    int64_t n_segment, segment, index, end; /* index of the next photon that is made, and the end in its segment */
    int32_t n_source, band, precision, next, made, has_positions;
    uint64_t reserves[5];
    int32_t patch[AOMC_SKY_BUFFER], component[AOMC_SKY_BUFFER];
    double light[AOMC_SKY_BUFFER]; /* weight times `photon_light` */
    union {
        float f32[6][AOMC_SKY_BUFFER];
        double f64[6][AOMC_SKY_BUFFER];
    } column; /* ux, uy, uz, weight, x, y */
} aomc_sky_stream;

/* Laws by which cells start: those of `direction`, and the first and the last one of lobes. */
enum { AOMC_SKY_CELL_MU2, AOMC_SKY_CELL_MU, AOMC_SKY_BEAM, AOMC_SKY_DISC, AOMC_SKY_DISC_AT_HORIZON };
enum { AOMC_SKY_HG = 6, AOMC_SKY_BECKMANN = 8 };
enum { AOMC_SKY_NARROW, AOMC_SKY_QUARTER, AOMC_SKY_ANY_WIDTH, AOMC_SKY_IN_MU };
enum { AOMC_SKY_POINT, AOMC_SKY_CIRCLE, AOMC_SKY_RECTANGLE }; /* footprints */

/* All functions. What each does stands at its definition. */
AOMC_SKY_HOST_API int aomc_sky_load(const char *path, aomc_sky_file *file);
AOMC_SKY_HOST_API int aomc_sky_view(const void *bytes, uint64_t size, aomc_sky_file *file);
AOMC_SKY_HOST_API void aomc_sky_unload(aomc_sky_file *file);
AOMC_SKY_HOST_API const char *aomc_sky_message(int64_t code);
AOMC_SKY_HOST_API uint64_t aomc_sky_checksum(const void *bytes, uint64_t size);
AOMC_SKY_HOST_API int aomc_sky_band(const aomc_sky_file *file, int32_t band, aomc_sky_source *source);
AOMC_SKY_HOST_API int aomc_sky_band_at(
    const aomc_sky_file *file, int32_t band, const void *device_bytes, aomc_sky_source *source);
AOMC_SKY_HOST_API int aomc_sky_weighted_band(const aomc_sky_file *file, int32_t band, aomc_sky_source *source);
AOMC_SKY_HOST_API int aomc_sky_weighted_band_at(
    const aomc_sky_file *file, int32_t band, const void *device_bytes, aomc_sky_source *source);
AOMC_SKY_HOST_API int aomc_sky_replicate(
    const aomc_sky_file *file, int32_t band, int32_t replicate, aomc_sky_source *source);
AOMC_SKY_HOST_API int aomc_sky_weighted_replicate(
    const aomc_sky_file *file, int32_t band, int32_t replicate, aomc_sky_source *source);
AOMC_SKY_HOST_API int aomc_sky_weighted_replicate_at(const aomc_sky_file *file, int32_t band, int32_t replicate,
    const void *device_bytes, aomc_sky_source *source);
AOMC_SKY_API int aomc_sky_witness(const aomc_sky_source *source);
AOMC_SKY_API int64_t aomc_sky_fill(
    const aomc_sky_source *source, int64_t start, int64_t count, float *ux, float *uy, float *uz);
AOMC_SKY_API int64_t aomc_sky_fill_double(
    const aomc_sky_source *source, int64_t start, int64_t count, double *ux, double *uy, double *uz);
AOMC_SKY_API int64_t aomc_sky_fill_weighted(const aomc_sky_source *source, int64_t start, int64_t count, float *ux,
    float *uy, float *uz, int32_t *patch, float *weight);
AOMC_SKY_API int64_t aomc_sky_fill_weighted_double(const aomc_sky_source *source, int64_t start, int64_t count,
    double *ux, double *uy, double *uz, int32_t *patch, double *weight);
AOMC_SKY_API int64_t aomc_sky_numbers(
    const aomc_sky_source *source, int64_t start, int64_t count, float *n1, float *n2, float *n3);
AOMC_SKY_API int64_t aomc_sky_numbers_double(
    const aomc_sky_source *source, int64_t start, int64_t count, double *n1, double *n2, double *n3);
AOMC_SKY_API int64_t aomc_sky_positions(
    const aomc_sky_source *source, int64_t start, int64_t count, float *x, float *y);
AOMC_SKY_API int64_t aomc_sky_positions_double(
    const aomc_sky_source *source, int64_t start, int64_t count, double *x, double *y);
AOMC_SKY_API aomc_sky_photon aomc_sky_at(const aomc_sky_source *source, int64_t i);
AOMC_SKY_API aomc_sky_photon_double aomc_sky_at_double(const aomc_sky_source *source, int64_t i);
AOMC_SKY_API double aomc_sky_weight(const aomc_sky_source *source, aomc_sky_photon photon);
AOMC_SKY_API double aomc_sky_weight_double(const aomc_sky_source *source, aomc_sky_photon_double photon);
AOMC_SKY_API int32_t aomc_sky_component(const aomc_sky_source *source, int32_t patch);
AOMC_SKY_API void aomc_sky_numbers_at(const aomc_sky_source *source, int64_t i, float *out);
AOMC_SKY_API void aomc_sky_numbers_at_double(const aomc_sky_source *source, int64_t i, double *out);
AOMC_SKY_API void aomc_sky_position(const aomc_sky_source *source, int64_t i, float *xy);
AOMC_SKY_API void aomc_sky_position_double(const aomc_sky_source *source, int64_t i, double *xy);
AOMC_SKY_HOST_API int aomc_sky_particles(
    aomc_sky_stream *stream, const aomc_sky_source *sources, int32_t n_sources, int64_t from, int64_t to);
AOMC_SKY_HOST_API int aomc_sky_next(aomc_sky_stream *stream, aomc_sky_particle *particle);

#ifndef AOMC_SKY_DECLARE_ONLY

#define SKY_LAST_TRIAL 10000
#define SKY_DRAW_ACCEPT 2147483648u
#define SKY_BLOCK 512
#define SKY_CHUNK 256
#define SKY_GROUP 16
#define SKY_STRETCH 128 /* ranks that are looked through together */
#define SKY_PIECE (256 / AOMC_SKY_PRECISION) /* whole vectors, and small enough that two are under way at once */
#define SKY_COLUMN 528 /* a block and a group */
#define SKY_LOW 0xFFFFFFFFu
#define SKY_UNKNOWN UINT64_C(0x7FF8000000000000) /* a witness says nothing of this number */

/* Square roots. Compilers make no vectors of a loop whose roots might set errno, and keep a call beside every single
 * one, so for the common processors they are written out. */
#if defined(SKY_AVX) || defined(SKY_SSE2)
SKY_FORMULA float aomc_sky_sqrt_f32(float x) { return _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))); }
SKY_FORMULA double aomc_sky_sqrt_f64(double x) { return _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set_sd(x))); }
#else
SKY_FORMULA float aomc_sky_sqrt_f32(float x) { return sqrtf(x); }
SKY_FORMULA double aomc_sky_sqrt_f64(double x) { return sqrt(x); }
#endif

/* Square roots of n numbers: all whole eights as vectors, so that gcc sees that a constant n of these leaves no rest */
SKY_FN void aomc_sky_roots_f32(uint64_t n, float *x) {
    uint64_t j = 0;
#if defined(SKY_AVX)
    for (; j < (n & ~UINT64_C(7)); j += 8) _mm256_storeu_ps(x + j, _mm256_sqrt_ps(_mm256_loadu_ps(x + j)));
#elif defined(SKY_SSE2)
    for (; j < (n & ~UINT64_C(7)); j += 4) _mm_storeu_ps(x + j, _mm_sqrt_ps(_mm_loadu_ps(x + j)));
#elif defined(SKY_NEON)
    for (; j < (n & ~UINT64_C(7)); j += 4) vst1q_f32(x + j, vsqrtq_f32(vld1q_f32(x + j)));
#endif
    for (; j < n; j++) x[j] = aomc_sky_sqrt_f32(x[j]);
}

SKY_FN void aomc_sky_roots_f64(uint64_t n, double *x) {
    uint64_t j = 0;
#if defined(SKY_AVX)
    for (; j < (n & ~UINT64_C(7)); j += 4) _mm256_storeu_pd(x + j, _mm256_sqrt_pd(_mm256_loadu_pd(x + j)));
#elif defined(SKY_SSE2)
    for (; j < (n & ~UINT64_C(7)); j += 2) _mm_storeu_pd(x + j, _mm_sqrt_pd(_mm_loadu_pd(x + j)));
#elif defined(SKY_NEON)
    for (; j < (n & ~UINT64_C(7)); j += 2) vst1q_f64(x + j, vsqrtq_f64(vld1q_f64(x + j)));
#endif
    for (; j < n; j++) x[j] = aomc_sky_sqrt_f64(x[j]);
}

/* ---- kernels/arithmetic/rng.py ---- */

/* philox_round: words of 32 bits in 64, as processors multiply them side by side */
SKY_FORMULA void aomc_sky_round(uint64_t *c, uint64_t k0, uint64_t k1) {
    uint64_t p0 = UINT64_C(0xD2511F53) * c[0], p1 = UINT64_C(0xCD9E8D57) * c[2];
    c[0] = (p1 >> 32) ^ c[1] ^ (k0 & SKY_LOW);
    c[1] = p1 & SKY_LOW;
    c[2] = (p0 >> 32) ^ c[3] ^ (k1 & SKY_LOW);
    c[3] = p0 & SKY_LOW;
}

/* philox_pair: two 64-bit words; counter (rank low, rank high, band, draw) */
SKY_FORMULA void aomc_sky_pair(uint64_t key, uint64_t rank, uint64_t band, uint64_t draw, uint64_t *a, uint64_t *b) {
    const uint64_t w0 = 0x9E3779B9u, w1 = 0xBB67AE85u;
    uint64_t c[4], k0 = key & SKY_LOW, k1 = key >> 32;
    c[0] = rank & SKY_LOW, c[1] = rank >> 32, c[2] = band, c[3] = draw;
    aomc_sky_round(c, k0, k1);
    aomc_sky_round(c, k0 + w0, k1 + w1);
    aomc_sky_round(c, k0 + 2 * w0, k1 + 2 * w1);
    aomc_sky_round(c, k0 + 3 * w0, k1 + 3 * w1);
    aomc_sky_round(c, k0 + 4 * w0, k1 + 4 * w1);
    aomc_sky_round(c, k0 + 5 * w0, k1 + 5 * w1);
    aomc_sky_round(c, k0 + 6 * w0, k1 + 6 * w1);
    aomc_sky_round(c, k0 + 7 * w0, k1 + 7 * w1);
    aomc_sky_round(c, k0 + 8 * w0, k1 + 8 * w1);
    aomc_sky_round(c, k0 + 9 * w0, k1 + 9 * w1);
    *a = c[0] << 32 | c[1];
    *b = c[2] << 32 | c[3];
}

/* The words of trial 0, which come back in registers. */
typedef struct aomc_sky_words {
    uint64_t a, b;
} aomc_sky_words;

SKY_APART aomc_sky_words aomc_sky_pair_apart(uint64_t key, uint64_t rank, uint64_t band) {
    aomc_sky_words words;
    aomc_sky_pair(key, rank, band, 0, &words.a, &words.b);
    return words;
}

/* The words of n ranks: a[k] and b[k]. In vectors gcc takes slow products of 64 bits for those of 32 in `pair`, so four
 * ranks are written out; what is above 32 bits in c never counts. */
SKY_APART void aomc_sky_pairs(uint64_t key, uint64_t n, const uint64_t *rank, uint64_t band, uint64_t draw,
    uint64_t *SKY_ALONE a, uint64_t *SKY_ALONE b) {
    uint64_t k = 0;
#if defined(SKY_AVX2)
    const __m256i m0 = _mm256_set1_epi64x(0xD2511F53), m1 = _mm256_set1_epi64x(0xCD9E8D57);
    const __m256i low = _mm256_set1_epi64x(SKY_LOW);
    for (; k < (n & ~UINT64_C(3)); k += 4) {
        __m256i c0 = _mm256_loadu_si256((const __m256i *)(const void *)(rank + k)), c1 = _mm256_srli_epi64(c0, 32);
        __m256i c2 = _mm256_set1_epi64x((long long)band), c3 = _mm256_set1_epi64x((long long)draw);
        uint32_t k0 = (uint32_t)key, k1 = (uint32_t)(key >> 32), round;
        for (round = 0; round < 10; round++, k0 += 0x9E3779B9u, k1 += 0xBB67AE85u) {
            __m256i p0 = _mm256_mul_epu32(c0, m0), p1 = _mm256_mul_epu32(c2, m1);
            c0 = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(p1, 32), c1), _mm256_set1_epi64x(k0));
            c2 = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(p0, 32), c3), _mm256_set1_epi64x(k1));
            c1 = p1, c3 = p0;
        }
        c0 = _mm256_or_si256(_mm256_slli_epi64(c0, 32), _mm256_and_si256(c1, low));
        c2 = _mm256_or_si256(_mm256_slli_epi64(c2, 32), _mm256_and_si256(c3, low));
        _mm256_storeu_si256((__m256i *)(void *)(a + k), c0);
        _mm256_storeu_si256((__m256i *)(void *)(b + k), c2);
    }
#endif
    for (; k < n; k++) aomc_sky_pair(key, rank[k], band, draw, a + k, b + k);
}

/* later_words: of the two words of a later trial, the place, 42 bits each, and the word that decides */
SKY_FORMULA uint64_t aomc_sky_split_off(uint64_t *a, uint64_t *b) {
    const uint64_t rest = (UINT64_C(1) << 22) - 1;
    uint64_t word = ((*a & rest) << 22 | (*b & rest)) << 20;
    *a &= ~rest;
    *b &= ~rest;
    return word;
}

SKY_FORMULA void aomc_sky_later(
    uint64_t key, uint64_t rank, uint64_t band, uint32_t trial, uint64_t *a, uint64_t *b, uint64_t *word) {
    aomc_sky_pair(key, rank, band, trial, a, b);
    *word = aomc_sky_split_off(a, b);
}

/* ---- kernels/cells/order.py ---- */

/* mix */
SKY_FORMULA uint32_t aomc_sky_mix(uint32_t half, uint32_t key) {
    uint32_t x = half * 0x7FEB352Du + key;
    x ^= x >> 15;
    return x * 0x846CA68Bu;
}

/* _high_short */
SKY_FORMULA uint32_t aomc_sky_high_short(uint32_t high, uint32_t low, uint32_t key, uint32_t size) {
    uint32_t up = high + ((aomc_sky_mix(low, key) >> 16) * (size & 0xFFFF) >> 16), less = up - size;
    return up < less ? up : less;
}

/* permute_short */
SKY_FORMULA uint32_t aomc_sky_permute_short(
    uint32_t i, uint32_t bits, uint32_t size, uint32_t k0, uint32_t k1, uint32_t k2) {
    uint32_t rest = (32 - bits) & 31, mask = ((uint32_t)1 << bits) - 1, low = i & mask, high;
    high = aomc_sky_high_short(i >> bits, low, k0, size);
    low = (low + (aomc_sky_mix(high, k1) >> rest)) & mask;
    high = aomc_sky_high_short(high, low, k2, size);
    return high << bits | low;
}

/* permute_long */
SKY_FORMULA uint64_t aomc_sky_permute_long(
    uint64_t i, uint64_t bits, uint64_t size, uint32_t k0, uint32_t k1, uint32_t k2) {
    uint64_t mask = (UINT64_C(1) << bits) - 1, low = i & mask, high = i >> bits;
    high += (aomc_sky_mix((uint32_t)low, k0) * size) >> 32;
    high = high >= size ? high - size : high;
    low = (low + ((uint64_t)aomc_sky_mix((uint32_t)high, k1) >> (32 - bits))) & mask;
    high += (aomc_sky_mix((uint32_t)low, k2) * size) >> 32;
    high = high >= size ? high - size : high;
    return high << bits | low;
}

/* ---- kernels/cells/blocks.py ---- */

/* rank_of_photon */
SKY_FORMULA uint64_t aomc_sky_rank(const aomc_sky_source *s, uint64_t i) {
    uint32_t k0 = (uint32_t)s->order_keys[0], k1 = (uint32_t)s->order_keys[1], k2 = (uint32_t)s->order_keys[2];
    uint64_t n = (uint64_t)s->n, r = i;
    if (!s->is_shuffled) return i;
    if (s->is_short) {
        uint32_t bits = (uint32_t)s->order_bits, size = (uint32_t)s->order_size, q = (uint32_t)i;
        do q = aomc_sky_permute_short(q, bits, size, k0, k1, k2);
        while (q >= n);
        return q;
    }
    do r = aomc_sky_permute_long(r, s->order_bits, s->order_size, k0, k1, k2);
    while (r >= n);
    return r;
}

/* photons before a slot */
SKY_FORMULA uint64_t aomc_sky_before(const aomc_sky_source *s, uint64_t slot) {
    return s->has_wide_ranks ? ((const uint64_t *)s->cumulative)[slot] : ((const uint32_t *)s->cumulative)[slot];
}

/* slot_of_rank */
SKY_FORMULA uint32_t aomc_sky_slot_short(
    const uint32_t *cumulative, const uint32_t *guide, uint32_t shift, uint32_t r) {
    uint32_t slot = guide[r >> shift];
    if (r < cumulative[slot + 2]) return slot + (r >= cumulative[slot + 1]);
    for (slot += 2; r >= cumulative[slot + 1]; slot++) {}
    return slot;
}

SKY_FORMULA uint32_t aomc_sky_slot_wide(const uint64_t *cumulative, const uint32_t *guide, uint64_t shift, uint64_t r) {
    uint32_t slot = guide[r >> shift];
    if (r < cumulative[slot + 2]) return slot + (r >= cumulative[slot + 1]);
    for (slot += 2; r >= cumulative[slot + 1]; slot++) {}
    return slot;
}

SKY_FORMULA uint32_t aomc_sky_slot(const aomc_sky_source *s, uint64_t r) {
    if (s->has_wide_ranks) return aomc_sky_slot_wide((const uint64_t *)s->cumulative, s->guide, s->guide_shift, r);
    return aomc_sky_slot_short((const uint32_t *)s->cumulative, s->guide, (uint32_t)s->guide_shift, (uint32_t)r);
}

/* ---- kernels/arithmetic/elementary.py: float64 alone ---- */

/* word_of and float_of */
SKY_FORMULA uint64_t aomc_sky_bits(double x) {
    uint64_t word;
    memcpy(&word, &x, 8);
    return word;
}

SKY_FORMULA double aomc_sky_double(uint64_t word) {
    double x;
    memcpy(&x, &word, 8);
    return x;
}

/* uniform_f64 */
SKY_FORMULA double aomc_sky_uniform(uint64_t bits) { return (double)(int64_t)(bits >> 11) * 1.1102230246251565e-16; }

/* split_power */
SKY_FORMULA double aomc_sky_split_power(double x, double *power) {
    uint64_t word = aomc_sky_bits(x);
    *power = (double)((int32_t)(word >> 52) - 1022);
    return aomc_sky_double((word & ((UINT64_C(1) << 52) - 1)) | UINT64_C(1022) << 52);
}

#define SKY_LN2_HIGH 6.93147180369123816490e-01
#define SKY_LN2_LOW 1.90821492927058770002e-10

/* log_of_parts */
SKY_FORMULA double aomc_sky_log_of_parts(double f, double k) {
    double s = f / (2.0 + f), z = s * s, half = 0.5 * f * f, r = 2.0 / 21 * z + 2.0 / 19;
    r = r * z + 2.0 / 17;
    r = r * z + 2.0 / 15;
    r = r * z + 2.0 / 13;
    r = r * z + 2.0 / 11;
    r = r * z + 2.0 / 9;
    r = r * z + 2.0 / 7;
    r = r * z + 2.0 / 5;
    r = r * z + 2.0 / 3;
    r = r * z;
    return k * SKY_LN2_HIGH - ((half - (s * (half + r) + k * SKY_LN2_LOW)) - f);
}

/* exp_level */
SKY_FORMULA double aomc_sky_exp(double x) {
    double t, k, high, low, r, z, c, y;
    x = x < 700.0 ? x : 700.0;
    x = x > -700.0 ? x : -700.0;
    t = x * 1.4426950408889634 + 6755399441055744.0;
    k = t - 6755399441055744.0;
    high = x - k * SKY_LN2_HIGH;
    low = k * SKY_LN2_LOW;
    r = high - low;
    z = r * r;
    c = 4.13813679705723846039e-08 * z + -1.65339022054652515390e-06;
    c = c * z + 6.61375632143793436117e-05;
    c = c * z + -2.77777777770155933842e-03;
    c = c * z + 1.66666666666666019037e-01;
    c = r - z * c;
    y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
    return y * aomc_sky_double((aomc_sky_bits(t) + 1023) << 52);
}

/* arc in four steps, for loops of their own: what the root is of; the root or q; the sum; the angle of its zone */
SKY_FORMULA double aomc_sky_arc_square(double h) {
    double q = 1.0 - (h + h), z = q > 0.5 ? h : q < -0.5 ? 1.0 - h : q * q;
    return z > 0.0 ? z : 0.0;
}

SKY_FORMULA double aomc_sky_arc_begin(double h, double root) {
    double q = 1.0 - (h + h);
    return ((q > 0.5) | (q < -0.5)) ? root : q;
}

SKY_FORMULA double aomc_sky_arc_sum(double z, double s) {
    double p = 3.47933107596021167570e-05 * z + 7.91534994289814532176e-04, d;
    p = p * z + -4.00555345006794114027e-02;
    p = p * z + 2.01212532134862925881e-01;
    p = p * z + -3.25565818622400915405e-01;
    p = p * z + 1.66666666666666657415e-01;
    d = 7.70381505559019352791e-02 * z + -6.88283971605453293030e-01;
    d = d * z + 2.02094576023350569471e00;
    d = d * z + -2.40339491173441421878e00;
    d = d * z + 1.0;
    return s + s * (z * p / d);
}

SKY_FORMULA double aomc_sky_arc_end(double h, double r) {
    const double half_pi = 1.5707963267948966;
    double q = 1.0 - (h + h), twice = r + r, beyond = 2.0 * half_pi - twice, within = half_pi - r;
    within = q < -0.5 ? beyond : within;
    return q > 0.5 ? twice : within;
}

/* ---- skies/perez/kernels: law.py and the float64 part of cells.py; `sky` holds a, b, c, d, e ---- */

/* slant */
SKY_FORMULA double aomc_sky_slant(double mu, double b) { return b / (mu > 1e-300 ? mu : 1e-300); }

/* with_aureole */
SKY_FORMULA double aomc_sky_with_aureole(double h, double c, double aureole, double e) {
    double q = 1.0 - (h + h);
    return 1.0 + c * aureole + e * (q * q);
}

/* the chord of `measured`: sin^2 of half the angle to the sun */
SKY_FORMULA double aomc_sky_chord(double x, double y, double z, const double *sky) {
    double dx = x + sky[8], dy = y + sky[9], dz = z + sky[10], h = 0.25 * ((dx * dx + dy * dy) + dz * dz);
    return h < 1.0 ? h : 1.0;
}

/* luminance */
SKY_FN double aomc_sky_luminance(double x, double y, double z, const double *sky) {
    double h = aomc_sky_chord(x, y, z, sky), first = 1.0 + sky[0] * aomc_sky_exp(aomc_sky_slant(-z, sky[1]));
    double square = aomc_sky_arc_square(h), s = aomc_sky_arc_begin(h, aomc_sky_sqrt_f64(square));
    double angle = aomc_sky_arc_end(h, aomc_sky_arc_sum(square, s));
    return first * aomc_sky_with_aureole(h, sky[2], aomc_sky_exp(sky[3] * angle), sky[4]);
}

/* is_taken_at_once */
SKY_FORMULA int aomc_sky_is_at_once(uint64_t word, uint32_t cell_word) { return (word >> 52) < (cell_word & 0xFFF); }

/* is_rejected */
SKY_FORMULA int aomc_sky_is_rejected(
    double x, double y, double z, double jacobian, uint64_t word, double bound, const double *sky) {
    return aomc_sky_uniform(word) * bound >= aomc_sky_luminance(x, y, z, sky) * jacobian;
}

/* the word that decides trial 0: of accept_words for Perez, of decision_by_rank for lobes, or of Philox */
SKY_FORMULA uint64_t aomc_sky_decision(int by_philox, const aomc_sky_source *s, uint64_t rank, int is_lobe) {
    uint64_t word = s->accept[0] + rank * s->accept[1], other, x;
    if (by_philox) {
        aomc_sky_pair(s->placement_key, rank, s->band, SKY_DRAW_ACCEPT, &word, &other);
    } else if (is_lobe) {
        x = (rank ^ s->accept[2]) * UINT64_C(0xD1342543DE82EF95);
        x ^= x >> 32;
        word += (x * UINT64_C(0xAF251AF3B0F025B5)) >> 1;
    }
    return word;
}

/* ---- kernels/arithmetic/net.py ---- */

/* reversed_bits */
SKY_FORMULA uint32_t aomc_sky_reversed(uint32_t x) {
    x = (x & 0xAAAAAAAAu) >> 1 | (x << 1 & 0xAAAAAAAAu);
    x = (x & 0xCCCCCCCCu) >> 2 | (x << 2 & 0xCCCCCCCCu);
    x = (x & 0xF0F0F0F0u) >> 4 | (x << 4 & 0xF0F0F0F0u);
    x = (x & 0xFF00FF00u) >> 8 | (x << 8 & 0xFF00FF00u);
    return x >> 16 | x << 16;
}

/* nested */
SKY_FORMULA uint32_t aomc_sky_nested(uint32_t x, uint64_t key) {
    x ^= x * 0x3D20ADEAu;
    x += (uint32_t)(key >> 32);
    x *= (uint32_t)key | 1;
    x ^= x * 0x05526C56u;
    return x ^ x * 0x53A22864u;
}

/* index_of_rank */
SKY_FORMULA uint32_t aomc_sky_point(uint64_t rank, uint64_t key) {
    uint32_t x = aomc_sky_reversed((uint32_t)rank) + (uint32_t)(rank >> 32) * 0x9E3779B9u;
    return aomc_sky_reversed(aomc_sky_nested(x, key));
}

/* digits_of_x_plus_1 */
SKY_FORMULA uint32_t aomc_sky_second(uint32_t v) {
    v ^= (v & 0xFFFF0000u) >> 16;
    v ^= (v & 0xFF00FF00u) >> 8;
    v ^= (v & 0xF0F0F0F0u) >> 4;
    v ^= (v & 0xCCCCCCCCu) >> 2;
    return v ^ (v & 0xAAAAAAAAu) >> 1;
}

/* digits_of_x2_plus_x_plus_1 */
SKY_FORMULA uint32_t aomc_sky_third(uint32_t v) {
    v ^= (v & 0xFFFF0000u) >> 8 ^ (v & 0x00FF0000u) >> 16 ^ (v & 0xFF000000u) >> 24;
    v ^= (v & 0xFF00FF00u) >> 4 ^ (v & 0x0F000F00u) >> 8 ^ (v & 0xF000F000u) >> 12;
    v ^= (v & 0xF0F0F0F0u) >> 2 ^ (v & 0x30303030u) >> 4 ^ (v & 0xC0C0C0C0u) >> 6;
    return v ^ (v & 0xCCCCCCCCu) >> 1 ^ (v & 0x44444444u) >> 2 ^ (v & 0x88888888u) >> 3;
}

/* net_word */
SKY_FORMULA uint64_t aomc_sky_net_word(uint32_t digits, uint64_t key) {
    uint32_t x = aomc_sky_nested(digits, key);
    return (uint64_t)aomc_sky_reversed(x) << 32 | (x * 0x9E3779B9u ^ (uint32_t)key);
}

/* ---- emission/kernels/numbers.py ---- */

/* the word of number c of a photon: three_numbers */
SKY_FORMULA uint64_t aomc_sky_number_word(const aomc_sky_source *s, uint64_t rank, int c) {
    uint64_t a, b;
    if (s->by_net) {
        uint32_t v = aomc_sky_point(rank, s->number_steps[0]);
        return aomc_sky_net_word(c == 0 ? v : c == 1 ? aomc_sky_second(v) : aomc_sky_third(v), s->number_shifts[c]);
    }
    if (!s->by_philox) return s->number_shifts[c] + rank * s->number_steps[c];
    aomc_sky_pair(s->position_key, rank, s->band, c == 2 ? 2 : 1, &a, &b);
    return c == 1 ? b : a;
}

/* A rank times a step: a rank of 32 bits takes two products of 32 bits, where processors have none of 64. */
SKY_FORMULA uint64_t aomc_sky_times(uint32_t rank, uint64_t step) {
    return (uint64_t)rank * (uint32_t)step + ((uint64_t)(rank * (uint32_t)(step >> 32)) << 32);
}

/* ranks_of_block, in stretches: one with a rank beyond the band is looked through for it */
SKY_APART void aomc_sky_ranks(const aomc_sky_source *s, uint64_t start, uint64_t m, uint64_t *rank) {
    uint64_t j = 0, end;
    if (!s->is_shuffled) {
        for (; j < m; j++) rank[j] = start + j;
    } else if (s->is_short) {
        uint32_t bits = (uint32_t)s->order_bits, size = (uint32_t)s->order_size, last = (uint32_t)(s->n - 1);
        uint32_t k0 = (uint32_t)s->order_keys[0], k1 = (uint32_t)s->order_keys[1], k2 = (uint32_t)s->order_keys[2];
        SKY_LINES uint32_t r[SKY_STRETCH];
        for (; j < m; j = end) {
            uint32_t first = (uint32_t)(start + j), most = 0, k, n;
            end = j + SKY_STRETCH < m ? j + SKY_STRETCH : m;
            n = (uint32_t)(end - j);
            for (k = 0; k < n; k++) {
                r[k] = aomc_sky_permute_short(first + k, bits, size, k0, k1, k2);
                most = r[k] > most ? r[k] : most;
            }
            for (k = 0; most > last && k < n; k++)
                while (r[k] > last) r[k] = aomc_sky_permute_short(r[k], bits, size, k0, k1, k2);
            for (k = 0; k < n; k++) rank[j + k] = r[k];
        }
    } else {
        for (; j < m; j++) rank[j] = aomc_sky_rank(s, start + j);
    }
}

/* _slots_shuffled */
SKY_APART void aomc_sky_slots(const aomc_sky_source *s, uint64_t m, const uint64_t *rank, int32_t *slot) {
    const uint32_t *guide = s->guide, *before = (const uint32_t *)s->cumulative;
    uint64_t j, shift = s->guide_shift;
    if (s->has_wide_ranks)
        for (j = 0; j < m; j++)
            slot[j] = (int32_t)aomc_sky_slot_wide((const uint64_t *)s->cumulative, guide, shift, rank[j]);
    else
        for (j = 0; j < m; j++)
            slot[j] = (int32_t)aomc_sky_slot_short(before, guide, (uint32_t)shift, (uint32_t)rank[j]);
}

/* where the parameters of cells are */
SKY_APART void aomc_sky_places_of_cells(
    uint64_t m, const uint64_t *SKY_ALONE places, const int32_t *SKY_ALONE cell, uint64_t *SKY_ALONE place) {
    uint64_t j;
    for (j = 0; j < m; j++) place[j] = places[(uint32_t)cell[j]];
}

/* accept_words of Perez and decision_by_rank of lobes: the words that decide trial 0 */
SKY_FN void aomc_sky_decisions(
    const aomc_sky_source *s, uint64_t m, const uint64_t *rank, int is_lobe, uint64_t *word) {
    uint64_t j, other[SKY_BLOCK];
    if (s->by_philox)
        aomc_sky_pairs(s->placement_key, m, rank, s->band, SKY_DRAW_ACCEPT, word, other);
    else if (is_lobe)
        for (j = 0; j < m; j++) word[j] = aomc_sky_decision(0, s, rank[j], 1);
    else
        for (j = 0; j < m; j++) word[j] = aomc_sky_decision(0, s, rank[j], 0);
}

/* Columns of `_luminance`. */
typedef struct aomc_sky_light {
    double chord[SKY_CHUNK], mu[SKY_CHUNK], square[SKY_CHUNK];
} SKY_LINES aomc_sky_light;

/* _luminance without J: each step has a loop of its own */
SKY_FN void aomc_sky_luminances(uint64_t n, const double *sky, aomc_sky_light *light, double *SKY_ALONE value) {
    double a = sky[0], b = sky[1], c = sky[2], d = sky[3], e = sky[4];
    uint64_t k;
    for (k = 0; k < n; k++) value[k] = light->square[k] = aomc_sky_arc_square(light->chord[k]);
    aomc_sky_roots_f64(n, value);
    for (k = 0; k < n; k++) value[k] = aomc_sky_arc_begin(light->chord[k], value[k]);
    for (k = 0; k < n; k++) value[k] = aomc_sky_arc_sum(light->square[k], value[k]);
    for (k = 0; k < n; k++) value[k] = d * aomc_sky_arc_end(light->chord[k], value[k]);
    for (k = 0; k < n; k++) value[k] = aomc_sky_with_aureole(light->chord[k], c, aomc_sky_exp(value[k]), e);
    for (k = 0; k < n; k++) light->mu[k] = aomc_sky_slant(light->mu[k], b);
    for (k = 0; k < n; k++) value[k] = (1.0 + a * aomc_sky_exp(light->mu[k])) * value[k];
}

/* Columns of photons of one lobe; `row` holds the cells of its envelope. */
typedef struct aomc_sky_lobe_columns {
    uint64_t rank[SKY_CHUNK], first[SKY_CHUNK], second[SKY_CHUNK], word[SKY_CHUNK];
    uint64_t bin[SKY_CHUNK];
    double row[8 * SKY_CHUNK], a[SKY_CHUNK], b[SKY_CHUNK], excess[SKY_CHUNK];
    double x[SKY_CHUNK], y[SKY_CHUNK], up[SKY_CHUNK];
    int32_t part[SKY_CHUNK];
} SKY_LINES aomc_sky_lobe_columns;

SKY_FN void aomc_sky_lobe_tries(
    const aomc_sky_source *s, int32_t lobe, uint32_t trial, uint64_t n, aomc_sky_lobe_columns *t);

SKY_FN void aomc_sky_lobe_photon(
    const aomc_sky_source *s, int32_t lobe, uint64_t first, uint64_t second, uint64_t rank, double *out);

/* ---- the text for one precision follows: at the end of the file, read twice ---- */

/* Whether photons of a cell are launched by solid angle */
SKY_FORMULA int aomc_sky_is_in_mu(const aomc_sky_source *s, int32_t cell) {
    return (s->law ? s->law[cell] : s->law_of_all) == AOMC_SKY_CELL_MU;
}

#define AOMC_SKY_PRECISION 4
#define SKY_F float
#define SKY_(name) aomc_sky_##name##_f32
#define SKY_RINT rintf
#include "aomc_sky.h"
#undef AOMC_SKY_PRECISION
#undef SKY_F
#undef SKY_
#undef SKY_RINT
#define AOMC_SKY_PRECISION 8
#define SKY_F double
#define SKY_(name) aomc_sky_##name##_f64
#define SKY_RINT rint
#include "aomc_sky.h"
#undef AOMC_SKY_PRECISION
#undef SKY_F
#undef SKY_
#undef SKY_RINT

/* ---- skies/lobes/kernels: law.py and cells.py, float64 for both precisions ---- */

/* bin_of_rank; the bits of the number are never above those of the lobe, whatever a file says */
SKY_FORMULA uint64_t aomc_sky_bin(const uint64_t *proposal, const double *line, uint64_t rank) {
    uint64_t own = rank - proposal[0], least = (uint64_t)(int32_t)((double)(int64_t)own * line[0] + line[1]);
    uint64_t above = least + 1;
    return least + (own >= proposal[1] * above + ((((proposal[2] * above) << 30) + proposal[3]) >> (proposal[4] + 30)));
}

/* shares */
SKY_FORMULA void aomc_sky_shares(double part, double span, double whole, const double *cell, double *a, double *b) {
    double t = (whole + 0.5) * 2.220446049250313080847263336181640625e-16;
    *a = cell[2] + cell[1] * ((cell[3] - span - part) + span * (1.0 - t));
    *b = cell[0] + cell[1] * (part + span * t);
}

/* whole_of */
SKY_FORMULA double aomc_sky_whole(uint64_t word, uint64_t bits) { return (double)(int64_t)((word << bits) >> 12); }

/* the square of beckmann_radius */
SKY_FORMULA double aomc_sky_beckmann_square(double a, double b) {
    double power, m = aomc_sky_split_power(b, &power), f;
    double twice = m + m, less = power - 1.0;
    f = (m < 0.7071067811865476 ? twice : m) - 1.0;
    power = m < 0.7071067811865476 ? less : power;
    return -aomc_sky_log_of_parts(a < 0.25 ? -a : f, a < 0.25 ? 0.0 : power);
}

/* _heights with squares for R, and for Z of "ggx" */
SKY_FORMULA void aomc_sky_squares(int kind, double g, double *a, double *b) {
    if (kind == 0) { /* heights_hg */
        double close = 1.0 - g, far = 1.0 + g, gb = g * *b;
        double p = (close * close) * (*a + *a * gb), q = (far * far) * (*b * (close + gb));
        *a = 4.0 * (p * q);
        *b = q - p;
    } else if (kind == 2) {
        *a = aomc_sky_beckmann_square(*a, *b);
        *b = 1.0;
    }
}

/* world before it is normalised: M (R cos, R sin, Z); returns the square of its length */
SKY_FORMULA double aomc_sky_world(
    double radius, double z, double sine, double cosine, const double *m, double *x, double *y, double *up) {
    double along = radius * cosine, across = radius * sine;
    double wx = m[0] * along + m[1] * across + m[2] * z, wy = m[3] * along + m[4] * across + m[5] * z;
    double wz = m[6] * along + m[7] * z;
    *x = wx;
    *y = wy;
    *up = wz;
    return wx * wx + wy * wy + wz * wz;
}

/* the kind of a lobe: 0 for "hg", 1 for "ggx", 2 for "beckmann" */
SKY_FORMULA int aomc_sky_kind(const aomc_sky_source *s, int32_t lobe) {
    return (lobe >= s->lobe_ends[0]) + (lobe >= s->lobe_ends[1]);
}

/* _try_one: a direction from two words, in the cell of bin `number`, which the first word names where `is_named` */
SKY_FN double aomc_sky_lobe_try(const aomc_sky_source *s, int32_t lobe, int is_named, uint64_t number, uint64_t first,
    uint64_t second, double *out) {
    const uint64_t *range = s->ranges + 4 * (uint64_t)lobe;
    const double *shape = s->shapes + 9 * (uint64_t)lobe, *cell;
    uint64_t bits = range[1];
    uint32_t word = s->bins[range[0] + ((is_named ? first >> (64 - bits) : number) & ((UINT64_C(1) << bits) - 1))];
    double a, b, sine, cosine, scale;
    int kind = aomc_sky_kind(s, lobe);
    cell = s->envelopes + 8 * (range[2] + (word >> 16));
    if (is_named) aomc_sky_shares((double)(word & 0xFFFF), 1.0, aomc_sky_whole(first, bits), cell, &a, &b);
    else aomc_sky_shares(0.0, cell[3], aomc_sky_whole(first, 0), cell, &a, &b);
    aomc_sky_squares(kind, shape[8], &a, &b);
    aomc_sky_turned_f64(AOMC_SKY_QUARTER, cell[5], cell[6], cell[4], aomc_sky_uniform(second), &sine, &cosine);
    scale = -1.0 / aomc_sky_sqrt_f64(aomc_sky_world(aomc_sky_sqrt_f64(a), kind == 1 ? aomc_sky_sqrt_f64(b) : b, sine,
                       cosine, shape, out, out + 1, out + 2));
    out[0] *= scale, out[1] *= scale, out[2] *= scale;
    return cell[7];
}

/* lobe_photon with _until_taken */
SKY_FN void aomc_sky_lobe_photon(
    const aomc_sky_source *s, int32_t lobe, uint64_t first, uint64_t second, uint64_t rank, double *out) {
    uint64_t word = aomc_sky_decision(s->by_philox, s, rank, 1), number = 0;
    int is_named = s->by_philox;
    uint32_t trial = 1;
    if (!is_named) number = aomc_sky_bin(s->bin_proposals + 5 * (uint64_t)lobe, s->bins_per_photon + 2 * (uint64_t)lobe, rank);
    for (;; trial++) {
        double bound = aomc_sky_lobe_try(s, lobe, is_named, number, first, second, out);
        if (aomc_sky_uniform(word) * bound + out[2] < 0.0 || trial >= SKY_LAST_TRIAL) return;
        aomc_sky_later(s->placement_key, rank, s->band, trial, &first, &second, &word);
        is_named = 1;
    }
}

/* ---- skies/lobes/kernels/cells.py: photons of a lobe side by side ---- */

/* Shares and directions of n photons. Clang makes vectors of these loops only where it is told that rows stand alone. */
SKY_FORMULA void aomc_sky_shares_of_rows(int is_named, uint64_t n, uint64_t bits, const uint64_t *first,
    const int32_t *part, const double *SKY_ALONE row, double *SKY_ALONE a, double *SKY_ALONE b) {
    uint64_t k;
    for (k = 0; k < n; k++)
        aomc_sky_shares(is_named ? (double)part[k] : 0.0, is_named ? 1.0 : row[8 * k + 3],
            aomc_sky_whole(first[k], is_named ? bits : 0), row + 8 * k, a + k, b + k);
}

SKY_FORMULA void aomc_sky_directions_of_rows(const double *shape, uint64_t n, const uint64_t *second,
    const uint64_t *word, const double *SKY_ALONE row, double *SKY_ALONE a, const double *SKY_ALONE b,
    double *SKY_ALONE excess, double *SKY_ALONE x, double *SKY_ALONE y, double *SKY_ALONE up) {
    uint64_t k;
    for (k = 0; k < n; k++) {
        double sine, cosine, v = aomc_sky_uniform(second[k]);
        aomc_sky_turned_f64(
            AOMC_SKY_QUARTER, row[8 * k + 5], row[8 * k + 6], row[8 * k + 4], v, &sine, &cosine);
        excess[k] = aomc_sky_uniform(word[k]) * row[8 * k + 7];
        a[k] = aomc_sky_world(a[k], b[k], sine, cosine, shape, x + k, y + k, up + k);
    }
}

/* _place_queue: one trial of n photons of a lobe, whose ranks are in t */
SKY_FN void aomc_sky_lobe_tries(
    const aomc_sky_source *s, int32_t lobe, uint32_t trial, uint64_t n, aomc_sky_lobe_columns *t) {
    const uint64_t *range = s->ranges + 4 * (uint64_t)lobe, *proposal = s->bin_proposals + 5 * (uint64_t)lobe;
    const double *shape = s->shapes + 9 * (uint64_t)lobe, *line = s->bins_per_photon + 2 * (uint64_t)lobe;
    const double *envelope = s->envelopes + 8 * range[2], g = shape[8];
    const uint32_t *bin = s->bins + range[0];
    uint64_t k, bits = range[1], mask = (UINT64_C(1) << bits) - 1;
    int kind = aomc_sky_kind(s, lobe), is_named = s->by_philox || trial > 0;
    for (; n % 8 != 0; n++) t->rank[n] = t->rank[n - 1]; /* whole vectors */
    if (is_named) aomc_sky_pairs(s->placement_key, n, t->rank, s->band, trial, t->first, t->second);
    else
        for (k = 0; k < n; k++) {
            t->first[k] = s->shifts[0] + t->rank[k] * s->steps[0];
            t->second[k] = s->shifts[1] + t->rank[k] * s->steps[1];
        }
    if (trial == 0) aomc_sky_decisions(s, n, t->rank, 1, t->word);
    else
        for (k = 0; k < n; k++) t->word[k] = aomc_sky_split_off(t->first + k, t->second + k);
    if (is_named)
        for (k = 0; k < n; k++) t->bin[k] = t->first[k] >> (64 - bits);
    else
        for (k = 0; k < n; k++) t->bin[k] = aomc_sky_bin(proposal, line, t->rank[k]);
    for (k = 0; k < n; k++) {
        uint32_t one = bin[t->bin[k] & mask];
        memcpy(t->row + 8 * k, envelope + 8 * (one >> 16), 64);
        t->part[k] = (int32_t)(one & 0xFFFF);
    }
    if (is_named) aomc_sky_shares_of_rows(1, n, bits, t->first, t->part, t->row, t->a, t->b);
    else aomc_sky_shares_of_rows(0, n, bits, t->first, t->part, t->row, t->a, t->b);
    /* _heights */
    if (kind == 0)
        for (k = 0; k < n; k++) aomc_sky_squares(0, g, t->a + k, t->b + k);
    else if (kind == 2)
        for (k = 0; k < n; k++) aomc_sky_squares(2, g, t->a + k, t->b + k);
    aomc_sky_roots_f64(n, t->a);
    if (kind == 1) aomc_sky_roots_f64(n, t->b);
    /* _azimuths and _directions */
    aomc_sky_directions_of_rows(
        shape, n, t->second, t->word, t->row, t->a, t->b, t->excess, t->x, t->y, t->up);
    aomc_sky_roots_f64(n, t->a);
    for (k = 0; k < n; k++) {
        double scale = -1.0 / t->a[k];
        t->x[k] *= scale;
        t->y[k] *= scale;
        t->up[k] *= scale;
        t->excess[k] += t->up[k];
    }
}

/* How many photons a call delivers, or a code. */
SKY_FN int64_t aomc_sky_due(const aomc_sky_source *s, int precision, int64_t start, int64_t count, int has_arrays) {
    if (!s) return AOMC_SKY_NULL;
    if (s->precision != precision) return AOMC_SKY_OTHER;
    if (start < 0 || count < 0) return AOMC_SKY_RANGE;
    if (start >= s->n || count == 0) return 0;
    if (!has_arrays) return AOMC_SKY_NULL;
    return count < s->n - start ? count : s->n - start;
}

/* ---- photons ---- */

/* Photon i of the band, 0 to n - 1. Of another i, of a source of float64, and of NULL: NaN, and patch -1. */
AOMC_SKY_API aomc_sky_photon aomc_sky_at(const aomc_sky_source *source, int64_t i) {
    float out[3] = {NAN, NAN, NAN};
    int32_t patch = -1;
    uint32_t words[3];
    uint64_t last;
    aomc_sky_photon p;
    if (source && i >= 0 && i < source->n && source->precision == 4)
        patch = aomc_sky_photon_f32(source, (uint64_t)i, out, NULL);
    /* in the two registers in which processors return it: through memory it takes as long again */
    memcpy(words, out, sizeof words);
    last = words[2] | (uint64_t)(uint32_t)patch << 32;
    memcpy((char *)&p + 8, &last, 8);
#if defined(SKY_AVX) || defined(SKY_SSE2)
    {
        double first = _mm_cvtsd_f64(_mm_castps_pd(_mm_unpacklo_ps(_mm_set_ss(out[0]), _mm_set_ss(out[1]))));
        memcpy(&p, &first, 8);
    }
#else
    {
        uint64_t first = words[0] | (uint64_t)words[1] << 32;
        memcpy(&p, &first, 8);
    }
#endif
    return p;
}

AOMC_SKY_API aomc_sky_photon_double aomc_sky_at_double(const aomc_sky_source *source, int64_t i) {
    double out[3] = {NAN, NAN, NAN};
    aomc_sky_photon_double p;
    p.patch = -1;
    if (source && i >= 0 && i < source->n && source->precision == 8)
        p.patch = aomc_sky_photon_f64(source, (uint64_t)i, out, NULL);
    p.ux = out[0], p.uy = out[1], p.uz = out[2];
    return p;
}

/* The three numbers of photon i, as `numbers=3` gives them in Python: for the first free path and the first
 * scattering. */
AOMC_SKY_API void aomc_sky_numbers_at(const aomc_sky_source *source, int64_t i, float *out) {
    int c, is_there = source && i >= 0 && i < source->n && source->precision == 4;
    uint64_t rank = is_there ? aomc_sky_rank(source, (uint64_t)i) : 0;
    for (c = 0; out && c < 3; c++) out[c] = is_there ? aomc_sky_unit_f32(aomc_sky_number_word(source, rank, c)) : NAN;
}

AOMC_SKY_API void aomc_sky_numbers_at_double(const aomc_sky_source *source, int64_t i, double *out) {
    int c, is_there = source && i >= 0 && i < source->n && source->precision == 8;
    uint64_t rank = is_there ? aomc_sky_rank(source, (uint64_t)i) : 0;
    for (c = 0; out && c < 3; c++) out[c] = is_there ? aomc_sky_unit_f64(aomc_sky_number_word(source, rank, c)) : NAN;
}

/* Position of photon i on the surface [m], x and y, as `batch.x` and `batch.y` in Python; 0 where the source is a point.
 * Of another i, of the other precision, and of NULL: NaN. */
AOMC_SKY_API void aomc_sky_position(const aomc_sky_source *source, int64_t i, float *xy) {
    if (!xy) return;
    xy[0] = xy[1] = NAN;
    if (source && i >= 0 && i < source->n && source->precision == 4)
        aomc_sky_position_range_f32(source, (uint64_t)i, 1, xy, xy + 1);
}

AOMC_SKY_API void aomc_sky_position_double(const aomc_sky_source *source, int64_t i, double *xy) {
    if (!xy) return;
    xy[0] = xy[1] = NAN;
    if (source && i >= 0 && i < source->n && source->precision == 8)
        aomc_sky_position_range_f64(source, (uint64_t)i, 1, xy, xy + 1);
}

/* Directions of the photons from `start` on, at most `count`. Returns how many; 0 at the end of the band; or a code. */
AOMC_SKY_API int64_t aomc_sky_fill(
    const aomc_sky_source *source, int64_t start, int64_t count, float *ux, float *uy, float *uz) {
    int64_t n = aomc_sky_due(source, 4, start, count, ux && uy && uz);
    return n <= 0 ? n : aomc_sky_range_f32(source, (uint64_t)start, (uint64_t)n, ux, uy, uz, NULL, NULL, NULL);
}

AOMC_SKY_API int64_t aomc_sky_fill_double(
    const aomc_sky_source *source, int64_t start, int64_t count, double *ux, double *uy, double *uz) {
    int64_t n = aomc_sky_due(source, 8, start, count, ux && uy && uz);
    return n <= 0 ? n : aomc_sky_range_f64(source, (uint64_t)start, (uint64_t)n, ux, uy, uz, NULL, NULL, NULL);
}

/* Weight of a photon that `at` gave: 1 where a file has no weights; NaN for a patch that is not there and for a source
 * of the other precision. */
AOMC_SKY_API double aomc_sky_weight(const aomc_sky_source *source, aomc_sky_photon photon) {
    float weight;
    if (!source || photon.patch < 0 || photon.patch >= source->n_cell || source->precision != 4) return NAN;
    if (!source->weights) return 1.0;
    weight = ((const float *)source->weights)[photon.patch];
    if (source->weight_has_mu && aomc_sky_is_in_mu(source, photon.patch)) weight *= -photon.uz;
    return (double)weight;
}

AOMC_SKY_API double aomc_sky_weight_double(const aomc_sky_source *source, aomc_sky_photon_double photon) {
    double weight;
    if (!source || photon.patch < 0 || photon.patch >= source->n_cell || source->precision != 8) return NAN;
    if (!source->weights) return 1.0;
    weight = ((const double *)source->weights)[photon.patch];
    if (source->weight_has_mu && aomc_sky_is_in_mu(source, photon.patch)) weight *= -photon.uz;
    return weight;
}

/* Number of the component of a patch, as `component_of` in Python; -1 for a patch that is not there, or of an older
 * file, which does not know. */
AOMC_SKY_API int32_t aomc_sky_component(const aomc_sky_source *source, int32_t patch) {
    uint64_t low = 0, high, middle;
    if (!source || patch < 0 || patch >= source->n_cell || source->n_component == 0) return -1;
    for (high = source->n_component - 1; low < high;) {
        middle = (low + high) / 2;
        if (patch < source->component_ends[middle]) high = middle;
        else low = middle + 1;
    }
    return (int32_t)low;
}

/* `fill`, and the patch and weight of each photon. Either of these two may be NULL: it is left out. */
AOMC_SKY_API int64_t aomc_sky_fill_weighted(const aomc_sky_source *source, int64_t start, int64_t count, float *ux,
    float *uy, float *uz, int32_t *patch, float *weight) {
    int64_t n = aomc_sky_due(source, 4, start, count, ux && uy && uz);
    return n <= 0 ? n : aomc_sky_range_f32(source, (uint64_t)start, (uint64_t)n, ux, uy, uz, NULL, patch, weight);
}

AOMC_SKY_API int64_t aomc_sky_fill_weighted_double(const aomc_sky_source *source, int64_t start, int64_t count,
    double *ux, double *uy, double *uz, int32_t *patch, double *weight) {
    int64_t n = aomc_sky_due(source, 8, start, count, ux && uy && uz);
    return n <= 0 ? n : aomc_sky_range_f64(source, (uint64_t)start, (uint64_t)n, ux, uy, uz, NULL, patch, weight);
}

/* The numbers of the same photons. A pointer may be NULL: that number is left out. */
AOMC_SKY_API int64_t aomc_sky_numbers(
    const aomc_sky_source *source, int64_t start, int64_t count, float *n1, float *n2, float *n3) {
    int64_t n = aomc_sky_due(source, 4, start, count, n1 || n2 || n3);
    if (n > 0) aomc_sky_number_range_f32(source, (uint64_t)start, (uint64_t)n, n1, n2, n3);
    return n;
}

AOMC_SKY_API int64_t aomc_sky_numbers_double(
    const aomc_sky_source *source, int64_t start, int64_t count, double *n1, double *n2, double *n3) {
    int64_t n = aomc_sky_due(source, 8, start, count, n1 || n2 || n3);
    if (n > 0) aomc_sky_number_range_f64(source, (uint64_t)start, (uint64_t)n, n1, n2, n3);
    return n;
}

/* The positions of the same photons. A pointer may be NULL: that column is left out. */
AOMC_SKY_API int64_t aomc_sky_positions(
    const aomc_sky_source *source, int64_t start, int64_t count, float *x, float *y) {
    int64_t n = aomc_sky_due(source, 4, start, count, x || y);
    if (n > 0) aomc_sky_position_range_f32(source, (uint64_t)start, (uint64_t)n, x, y);
    return n;
}

AOMC_SKY_API int64_t aomc_sky_positions_double(
    const aomc_sky_source *source, int64_t start, int64_t count, double *x, double *y) {
    int64_t n = aomc_sky_due(source, 8, start, count, x || y);
    if (n > 0) aomc_sky_position_range_f64(source, (uint64_t)start, (uint64_t)n, x, y);
    return n;
}

/* ---- a stream of particles: segment s of S has photons [floor(n s / S), floor(n (s + 1) / S)) of every band, one band
 * after the other ---- */

/* floor(n s / S); S is at most 2^31, so that no product overflows */
SKY_FORMULA int64_t aomc_sky_share(int64_t n, int64_t segment, int64_t n_segment) {
    return n / n_segment * segment + n % n_segment * segment / n_segment;
}

/* particles before a segment */
SKY_HOST int64_t aomc_sky_before_segment(const aomc_sky_stream *t, int64_t segment) {
    int64_t before = 0;
    int32_t k;
    for (k = 0; k < t->n_source; k++) before += aomc_sky_share(t->sources[k].n, segment, t->n_segment);
    return before;
}

/* the photons of the stream's band and segment */
SKY_FN void aomc_sky_enter(aomc_sky_stream *t) {
    int64_t n = t->sources[t->band].n;
    t->index = aomc_sky_share(n, t->segment, t->n_segment);
    t->end = aomc_sky_share(n, t->segment + 1, t->n_segment);
}

/* Begin a stream over the photons of all sources, bands of one file or of several, from place `from` to before `to`, or
 * to its end. `stream->n` is then the number of particles of the whole stream. Threads and ranks take ranges that follow
 * each other. Returns 0 or a code. The sources must stay where they are. */
AOMC_SKY_HOST_API int aomc_sky_particles(
    aomc_sky_stream *stream, const aomc_sky_source *sources, int32_t n_sources, int64_t from, int64_t to) {
    int64_t n = 0, low = 0, high, middle;
    int32_t k, n_lit = 0;
    if (!stream) return AOMC_SKY_NULL;
    memset(stream, 0, sizeof *stream);
    if (!sources) return AOMC_SKY_NULL;
    if (n_sources < 1) return AOMC_SKY_NO_BAND;
    if (from < 0 || to < from) return AOMC_SKY_RANGE;
    for (k = 0; k < n_sources; k++) {
        const aomc_sky_source *s = sources + k;
        int is_absolute = s->irradiance_W_m2_nm == s->irradiance_W_m2_nm;
        int is_first_absolute = sources->irradiance_W_m2_nm == sources->irradiance_W_m2_nm;
        if (s->precision != sources->precision || (s->precision != 4 && s->precision != 8)) return AOMC_SKY_OTHER;
        if (is_absolute != is_first_absolute) return AOMC_SKY_UNITS;
        if (s->n > INT64_MAX - n) return AOMC_SKY_RANGE;
        n += s->n, n_lit += s->n > 0;
    }
    stream->n = n, stream->sources = sources, stream->n_source = n_sources, stream->precision = sources->precision;
    stream->to = to < n ? to : n;
    stream->at = from < n ? from : n;
    if (stream->at == stream->to) return 0;
    high = (n - 1) / ((int64_t)2048 * n_lit) + 1;
    stream->n_segment = high = high < INT64_C(1) << 31 ? high : INT64_C(1) << 31;
    while (high - low > 1) { /* the last segment that does not begin behind `from` */
        middle = (low + high) / 2;
        if (aomc_sky_before_segment(stream, middle) <= from) low = middle;
        else high = middle;
    }
    stream->segment = low;
    from -= aomc_sky_before_segment(stream, low);
    for (aomc_sky_enter(stream); from >= stream->end - stream->index; aomc_sky_enter(stream)) {
        from -= stream->end - stream->index;
        stream->band++;
    }
    stream->index += from;
    return 0;
}

/* Make the next photons of a stream that is not at its end: 1, or a code. */
SKY_APART int aomc_sky_make_particles(aomc_sky_stream *t) {
    const aomc_sky_source *s;
    int64_t left = t->to - t->at, n, made;
    int32_t *patch = t->patch, *component = t->component, c, k, is_weighted;
    for (; t->index == t->end; aomc_sky_enter(t))
        if (++t->band == t->n_source) t->band = 0, t->segment++;
    s = t->sources + t->band;
    n = t->end - t->index;
    n = n < left ? n : left;
    n = n < (int64_t)AOMC_SKY_BUFFER ? n : (int64_t)AOMC_SKY_BUFFER;
    is_weighted = s->weights != NULL, t->has_positions = s->footprint != AOMC_SKY_POINT;
    if (t->precision == 4) {
        float(*f)[AOMC_SKY_BUFFER] = t->column.f32;
        made = aomc_sky_range_f32(s, (uint64_t)t->index, (uint64_t)n, f[0], f[1], f[2], NULL, patch,
            is_weighted ? f[3] : NULL);
        if (t->has_positions) aomc_sky_position_range_f32(s, (uint64_t)t->index, (uint64_t)n, f[4], f[5]);
        for (k = 0; is_weighted && k < (int32_t)n; k++) t->light[k] = (double)f[3][k] * s->photon_light;
    } else {
        double(*f)[AOMC_SKY_BUFFER] = t->column.f64;
        made = aomc_sky_range_f64(s, (uint64_t)t->index, (uint64_t)n, f[0], f[1], f[2], NULL, patch,
            is_weighted ? f[3] : NULL);
        if (t->has_positions) aomc_sky_position_range_f64(s, (uint64_t)t->index, (uint64_t)n, f[4], f[5]);
        for (k = 0; is_weighted && k < (int32_t)n; k++) t->light[k] = f[3][k] * s->photon_light;
    }
    for (k = 0; !is_weighted && k < (int32_t)n; k++) t->light[k] = s->photon_light;
    if (made < 0) return (int)made;
    for (k = 0; k < (int32_t)n; k++) component[k] = s->n_component ? 0 : -1;
    for (c = 0; c + 1 < (int64_t)s->n_component; c++) {
        int32_t end = s->component_ends[c];
        for (k = 0; k < (int32_t)n; k++) component[k] += patch[k] >= end;
    }
    t->index += n, t->made = (int32_t)n, t->next = 0;
    return 1;
}

/* Whether sums are rounded to nearest: a thread may round another way, and then its photons have other bits. */
SKY_FN int aomc_sky_is_nearest(void) {
    volatile double one = 1.0, half = 1.1102230246251565e-16; /* half of the last digit of 1 */
    return one + half == one && -one - half == -one && one - 0.25 * half == one;
}

/* 0 where this translation unit, or this GPU, gives the photons that the file knows, else AOMC_SKY_ARITHMETIC. Fast
 * math changes one photon in thousands, which no witness needs to be, so its macros are an answer, too. */
AOMC_SKY_API int aomc_sky_witness(const aomc_sky_source *source) {
    int32_t k;
    if (!source) return AOMC_SKY_NULL;
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) ||                         \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
    if (source->n > 0) return AOMC_SKY_ARITHMETIC;
#endif
    if (!aomc_sky_is_nearest()) return AOMC_SKY_ARITHMETIC;
    for (k = 0; k < source->n_witness; k++) {
        const uint64_t *w = source->witnesses + 12 * (uint64_t)k;
        int is_same = source->precision == 4 ? aomc_sky_agrees_f32(source, w) : aomc_sky_agrees_f64(source, w);
        if (!is_same) return AOMC_SKY_ARITHMETIC;
    }
    return 0;
}

/* ---- the file: emission/source_file.py ---- */

enum {
    AOMC_SKY_CUMULATIVE = 1,
    AOMC_SKY_GUIDE,
    AOMC_SKY_CELL_OF_SLOT,
    AOMC_SKY_PLACE,
    AOMC_SKY_WORDS,
    AOMC_SKY_LAW,
    AOMC_SKY_SLOPES,
    AOMC_SKY_PEREZ_WORD,
    AOMC_SKY_PEREZ_BOUND,
    AOMC_SKY_PEREZ_SKY,
    AOMC_SKY_LOBE,
    AOMC_SKY_RANGES,
    AOMC_SKY_BINS,
    AOMC_SKY_SHAPES,
    AOMC_SKY_ENVELOPES,
    AOMC_SKY_BIN_PROPOSALS,
    AOMC_SKY_BINS_PER_PHOTON,
    AOMC_SKY_WITNESSES,
    AOMC_SKY_STOKES,
    AOMC_SKY_WEIGHT,
    AOMC_SKY_COMPONENTS,
    AOMC_SKY_REPLICATE_COUNT,
    AOMC_SKY_LAST_KIND = AOMC_SKY_REPLICATE_COUNT
};
enum { AOMC_SKY_MOST_REPLICATES = 4096, AOMC_SKY_HEAD_BYTES = 192, AOMC_SKY_RECORD_WORDS = 40, AOMC_SKY_ENTRY_WORDS = 3 };

/* Checksum over a file of whole words but for its own word, the sixth. */
AOMC_SKY_HOST_API uint64_t aomc_sky_checksum(const void *bytes, uint64_t size) {
    const unsigned char *from = (const unsigned char *)bytes;
    uint64_t i, sum = 0, word;
    for (i = 0; i < size / 8; i++) {
        memcpy(&word, from + 8 * i, 8);
        word = ((i == 5 ? 0 : word) ^ (i * UINT64_C(0x9E3779B97F4A7C15))) * UINT64_C(0xD1342543DE82EF95);
        sum += (word ^ (word >> 32)) * UINT64_C(0xAF251AF3B0F025B5);
    }
    return sum;
}

/* A section of a band as the file has it: bytes are at `at`, NULL where there is none. */
typedef struct aomc_sky_section {
    const unsigned char *at;
    uint64_t offset, width, count;
} aomc_sky_section;

/* The sections of a band by their kinds. Kinds that this header does not know are skipped, unless the file needs
 * them. */
SKY_HOST int aomc_sky_sections(const aomc_sky_file *file, const uint64_t *record, aomc_sky_section *sections) {
    uint64_t k, at = record[5], entry[AOMC_SKY_ENTRY_WORDS];
    memset(sections, 0, (AOMC_SKY_LAST_KIND + 1) * sizeof *sections);
    if (at % 8 != 0 || at > file->size || record[6] > (file->size - at) / sizeof entry) return AOMC_SKY_DIRECTORY;
    for (k = 0; k < record[6]; k++) {
        aomc_sky_section s;
        uint32_t kind, is_needed;
        memcpy(entry, file->bytes + at + k * sizeof entry, sizeof entry);
        kind = (uint32_t)entry[0], s.width = (entry[0] >> 32) & 0xFFFF, is_needed = (uint32_t)(entry[0] >> 48);
        s.offset = entry[1], s.count = entry[2];
        if (s.offset % 64 != 0 || s.offset > file->size || s.width == 0) return AOMC_SKY_DIRECTORY;
        if (s.count > (file->size - s.offset) / s.width) return AOMC_SKY_DIRECTORY;
        s.at = file->bytes + s.offset;
        if (kind >= 1 && kind <= AOMC_SKY_LAST_KIND) {
            if (sections[kind].at) return AOMC_SKY_DIRECTORY;
            sections[kind] = s;
        } else if (is_needed) {
            return AOMC_SKY_NEWER;
        }
    }
    return 0;
}

/* Whether a section has this width and count; one that may be missing has none, or these. */
SKY_HOST int aomc_sky_fits(const aomc_sky_section *s, uint64_t width, uint64_t count, int may_be_missing) {
    if (!s->at) return may_be_missing;
    return s->width == width && s->count == count;
}

/* The one cell that has not the law of all, if it is a disc; else -1. */
SKY_HOST int32_t aomc_sky_one_disc(const int8_t *law, int32_t n_cell, int32_t law_of_all) {
    int32_t k, n = 0, other = -1;
    for (k = 0; law && k < n_cell; k++)
        if (law[k] != law_of_all) n++, other = k;
    return n == 1 && law[other] == AOMC_SKY_DISC ? other : -1;
}

/* `split_order`, and the scalars of a band from its record. */
SKY_HOST int aomc_sky_read_record(const aomc_sky_file *file, const uint64_t *r, aomc_sky_source *s) {
    uint64_t bits = 1, n = r[0], k;
    memset(s, 0, sizeof *s);
    s->precision = file->precision;
    memcpy(&s->wavelength_nm, r + 3, 8);
    memcpy(&s->irradiance_W_m2_nm, r + 4, 8);
    if (n > UINT64_C(1) << 62 || r[1] > 0x7FFFFFF0 || r[2] > 0x7FFFFFF0) return AOMC_SKY_TABLE;
    if (r[7] > 5) return AOMC_SKY_NEWER;
    s->n = (int64_t)n, s->n_slot = (int32_t)r[1], s->n_cell = (int32_t)r[2];
    s->is_shuffled = (int32_t)(r[7] & 1), s->by_philox = (int32_t)(r[7] >> 1 & 1), s->by_net = r[7] >> 2;
    while (bits < 31 && UINT64_C(1) << (2 * bits) < n) bits++;
    s->order_bits = bits, s->order_size = ((n - 1) >> bits) + 1, s->is_short = n <= UINT64_C(65535) << 16;
    for (k = 0; k < 3; k++) {
        s->order_keys[k] = r[8 + k], s->accept[k] = r[19 + k];
        s->number_shifts[k] = r[22 + k], s->number_steps[k] = r[25 + k];
        if (r[8 + k] > SKY_LOW) return AOMC_SKY_TABLE;
    }
    for (k = 0; k < 2; k++) s->shifts[k] = r[11 + k], s->steps[k] = r[13 + k], s->lobe_ends[k] = (int32_t)r[28 + k];
    s->placement_key = r[15], s->position_key = r[16], s->band = r[17], s->guide_shift = r[18];
    s->azimuth_kernel = (int32_t)r[30], s->has_wide_ranks = n >= UINT64_C(1) << 32;
    if (r[17] > SKY_LOW || r[18] > (s->has_wide_ranks ? 62 : 31) || r[30] > AOMC_SKY_IN_MU) return AOMC_SKY_TABLE;
    memcpy(&s->photon_light, r + 31, 8);
    if (!(s->photon_light >= 0.0 && s->photon_light <= DBL_MAX)) return AOMC_SKY_TABLE;
    if (s->photon_light == 0.0 && n > 0) /* an older file: it does not say */
        s->photon_light = s->irradiance_W_m2_nm == s->irradiance_W_m2_nm ? s->irradiance_W_m2_nm / (double)n : 1.0;
    if ((r[32] & 0xFF) > AOMC_SKY_RECTANGLE || r[32] >> 9) return AOMC_SKY_NEWER;
    s->footprint = r[32] & 0xFF, s->weight_has_mu = r[32] >> 8;
    memcpy(s->footprint_m, r + 33, 16);
    for (k = 0; k < 2; k++)
        if (!(s->footprint_m[k] >= 0.0 && s->footprint_m[k] <= DBL_MAX)) return AOMC_SKY_TABLE;
    if (s->footprint == AOMC_SKY_CIRCLE && r[33] != r[34]) return AOMC_SKY_TABLE;
    return r[28] > r[29] || r[29] > 0x7FFFFFF0 ? AOMC_SKY_TABLE : 0;
}

/* The band of a replicate with pointers from `base` on. The lengths of its sections are checked, what is in them is
 * not. */
SKY_HOST int aomc_sky_open_band(const aomc_sky_file *file, int32_t band, int32_t replicate, const void *base,
    aomc_sky_source *s, aomc_sky_section *t) {
    uint64_t r[AOMC_SKY_RECORD_WORDS], at, n_cell, n_lobe;
    const unsigned char *from = (const unsigned char *)base;
    const int8_t *law;
    int code;
    memcpy(&at, file->bytes + 56, 8);
    memcpy(r, file->bytes + at + ((uint64_t)replicate * (uint64_t)file->n_bands + (uint64_t)band) * sizeof r, sizeof r);
    if (r[35] != (uint64_t)replicate) return AOMC_SKY_DIRECTORY;
    code = aomc_sky_read_record(file, r, s);
    if (code == 0) code = aomc_sky_sections(file, r, t);
    if (code != 0 || s->n == 0) return code;
    n_cell = (uint64_t)s->n_cell, n_lobe = t[AOMC_SKY_RANGES].count / 4;
    if (s->n_slot < 1 || s->n_slot > s->n_cell || (!t[AOMC_SKY_CELL_OF_SLOT].at && s->n_slot != s->n_cell) ||
        !aomc_sky_fits(t + AOMC_SKY_CUMULATIVE, s->has_wide_ranks ? 8 : 4, (uint64_t)s->n_slot + 3, 0) ||
        !aomc_sky_fits(t + AOMC_SKY_GUIDE, 4, (((uint64_t)s->n - 1) >> s->guide_shift) + 1, 0) ||
        !aomc_sky_fits(t + AOMC_SKY_CELL_OF_SLOT, 4, (uint64_t)s->n_slot, 1) ||
        !aomc_sky_fits(t + AOMC_SKY_PLACE, 8, n_cell, 0) || !t[AOMC_SKY_WORDS].at || t[AOMC_SKY_WORDS].width != 8 ||
        !aomc_sky_fits(t + AOMC_SKY_LAW, 1, n_cell, 1) || !aomc_sky_fits(t + AOMC_SKY_SLOPES, 8, n_cell, 1) ||
        !aomc_sky_fits(t + AOMC_SKY_PEREZ_WORD, 4, n_cell, 1) ||
        !aomc_sky_fits(t + AOMC_SKY_PEREZ_BOUND, 8, n_cell, !t[AOMC_SKY_PEREZ_WORD].at) ||
        !aomc_sky_fits(t + AOMC_SKY_PEREZ_SKY, 8, 11, !t[AOMC_SKY_PEREZ_WORD].at) ||
        !aomc_sky_fits(t + AOMC_SKY_LOBE, 4, n_cell, 1))
        return AOMC_SKY_DIRECTORY;
    if (t[AOMC_SKY_LOBE].at &&
        (n_lobe < 1 || n_lobe > n_cell || !aomc_sky_fits(t + AOMC_SKY_RANGES, 8, 4 * n_lobe, 0) ||
            !t[AOMC_SKY_BINS].at || t[AOMC_SKY_BINS].width != 4 ||
            !aomc_sky_fits(t + AOMC_SKY_SHAPES, 8, 9 * n_lobe, 0) || !t[AOMC_SKY_ENVELOPES].at ||
            t[AOMC_SKY_ENVELOPES].width != 8 || !aomc_sky_fits(t + AOMC_SKY_BIN_PROPOSALS, 8, 5 * n_lobe, 0) ||
            !aomc_sky_fits(t + AOMC_SKY_BINS_PER_PHOTON, 8, 2 * n_lobe, 0)))
        return AOMC_SKY_DIRECTORY;
    if (!t[AOMC_SKY_WITNESSES].at || t[AOMC_SKY_WITNESSES].width != 8 || t[AOMC_SKY_WITNESSES].count > 12 * 4096 ||
        t[AOMC_SKY_WITNESSES].count % 12 != 0 || !aomc_sky_fits(t + AOMC_SKY_STOKES, 4, 2 * n_cell, 1))
        return AOMC_SKY_DIRECTORY;
    s->n_component = t[AOMC_SKY_COMPONENTS].count;
    if (!aomc_sky_fits(t + AOMC_SKY_WEIGHT, (uint64_t)s->precision, n_cell, !s->weight_has_mu) ||
        !aomc_sky_fits(t + AOMC_SKY_REPLICATE_COUNT, 4, 1, file->n_replicates == 1) ||
        (t[AOMC_SKY_COMPONENTS].at &&
            (t[AOMC_SKY_COMPONENTS].width != 4 || s->n_component < 1 || s->n_component > n_cell)))
        return AOMC_SKY_DIRECTORY;
#define AOMC_SKY_AT(kind, type) (t[kind].at ? (const type *)(const void *)(from + t[kind].offset) : NULL)
    s->cumulative = AOMC_SKY_AT(AOMC_SKY_CUMULATIVE, void);
    s->guide = AOMC_SKY_AT(AOMC_SKY_GUIDE, uint32_t);
    s->cell_of_slot = AOMC_SKY_AT(AOMC_SKY_CELL_OF_SLOT, int32_t);
    s->place = AOMC_SKY_AT(AOMC_SKY_PLACE, uint64_t);
    s->words = AOMC_SKY_AT(AOMC_SKY_WORDS, uint64_t);
    s->law = AOMC_SKY_AT(AOMC_SKY_LAW, int8_t);
    s->slopes = AOMC_SKY_AT(AOMC_SKY_SLOPES, uint64_t);
    s->perez_word = AOMC_SKY_AT(AOMC_SKY_PEREZ_WORD, uint32_t);
    s->perez_bound = AOMC_SKY_AT(AOMC_SKY_PEREZ_BOUND, double);
    s->sky = AOMC_SKY_AT(AOMC_SKY_PEREZ_SKY, double);
    s->lobe = AOMC_SKY_AT(AOMC_SKY_LOBE, int32_t);
    s->ranges = AOMC_SKY_AT(AOMC_SKY_RANGES, uint64_t);
    s->bins = AOMC_SKY_AT(AOMC_SKY_BINS, uint32_t);
    s->shapes = AOMC_SKY_AT(AOMC_SKY_SHAPES, double);
    s->envelopes = AOMC_SKY_AT(AOMC_SKY_ENVELOPES, double);
    s->bin_proposals = AOMC_SKY_AT(AOMC_SKY_BIN_PROPOSALS, uint64_t);
    s->bins_per_photon = AOMC_SKY_AT(AOMC_SKY_BINS_PER_PHOTON, double);
    s->witnesses = AOMC_SKY_AT(AOMC_SKY_WITNESSES, uint64_t);
    s->stokes = AOMC_SKY_AT(AOMC_SKY_STOKES, float);
    s->weights = AOMC_SKY_AT(AOMC_SKY_WEIGHT, void);
    s->component_ends = AOMC_SKY_AT(AOMC_SKY_COMPONENTS, int32_t);
#undef AOMC_SKY_AT
    s->law_of_all = s->azimuth_kernel == AOMC_SKY_IN_MU ? AOMC_SKY_CELL_MU : AOMC_SKY_CELL_MU2;
    s->n_witness = (int32_t)(t[AOMC_SKY_WITNESSES].count / 12);
    law = t[AOMC_SKY_LAW].at ? (const int8_t *)(const void *)(file->bytes + t[AOMC_SKY_LAW].offset) : NULL;
    s->disc_cell = aomc_sky_one_disc(law, s->n_cell, s->law_of_all); /* `from` may be memory of a device */
    s->is_common =
        s->azimuth_kernel <= AOMC_SKY_QUARTER && (!s->law || s->disc_cell >= 0) && !s->slopes && !s->perez_word && !s->lobe;
    return 0;
}

/* Whether all are finite and at most `limit` in size. */
SKY_HOST int aomc_sky_are_bounded(const double *x, uint64_t n, double limit) {
    uint64_t k, bad = 0;
    for (k = 0; k < n; k++) bad += !(x[k] <= limit && x[k] >= -limit);
    return bad == 0;
}

/* Whether the tables of ranks and slots lead from every rank to its slot, and every slot to a cell. */
SKY_HOST int aomc_sky_check_slots(const aomc_sky_source *s) {
    uint64_t k, n = (uint64_t)s->n, n_slot = (uint64_t)s->n_slot, top = s->has_wide_ranks ? UINT64_MAX : SKY_LOW;
    uint64_t last = (n - 1) >> s->guide_shift, bad = 0;
    if (aomc_sky_before(s, 0) != 0 || aomc_sky_before(s, n_slot) != n) return 0;
    for (k = 0; k < n_slot; k++) bad += aomc_sky_before(s, k + 1) < aomc_sky_before(s, k);
    if (bad || aomc_sky_before(s, n_slot + 1) != top || aomc_sky_before(s, n_slot + 2) != top) return 0;
    for (k = 0; k <= last; k++) {
        if (s->guide[k] >= n_slot) return 0;
        bad += aomc_sky_before(s, s->guide[k]) > k << s->guide_shift;
    }
    for (k = 0; s->cell_of_slot && k < n_slot; k++) bad += s->cell_of_slot[k] < 0 || s->cell_of_slot[k] >= s->n_cell;
    return bad == 0;
}

/* Whether every cell has its parameters, its law and its slopes within bounds. */
SKY_HOST int aomc_sky_check_cells(const aomc_sky_source *s, uint64_t n_words) {
    uint64_t row = s->precision == 4 ? 2 : 4, bad = 0;
    int32_t k, c;
    if (n_words < row) return 0;
    for (k = 0; k < s->n_cell; k++) {
        double p[6];
        if ((s->place[k] >> 32) > n_words - row || (s->place[k] & SKY_LOW) > n_words - row) return 0;
        if (s->precision == 4) {
            float q[6];
            aomc_sky_cell_f32(s, k, q);
            for (c = 0; c < 6; c++) p[c] = (double)q[c];
        } else {
            aomc_sky_cell_f64(s, k, p);
        }
        bad += !aomc_sky_are_bounded(p, 6, DBL_MAX) || !aomc_sky_are_bounded(p + 3, 1, 4.0);
        bad += !aomc_sky_are_bounded(p + 1, 1, 4.0);
        if (s->law && s->lobe && s->lobe[k] >= 0) bad += s->law[k] < AOMC_SKY_HG || s->law[k] > AOMC_SKY_BECKMANN;
        else if (s->law) bad += s->law[k] < 0 || s->law[k] > AOMC_SKY_DISC_AT_HORIZON;
        if (s->slopes) {
            int32_t u = (int32_t)(s->slopes[k] >> 32), v = (int32_t)(s->slopes[k] & SKY_LOW);
            bad += u <= -(1 << 30) || u >= 1 << 30 || v <= -(1 << 30) || v >= 1 << 30;
        }
        if (s->stokes) bad += !(s->stokes[2 * k] >= -2.0f && s->stokes[2 * k] <= 2.0f);
        if (s->stokes) bad += !(s->stokes[2 * k + 1] >= -2.0f && s->stokes[2 * k + 1] <= 2.0f);
        if (s->perez_word) {
            double bound = s->perez_bound[k];
            bad += !((bound >= 0.0 && bound <= DBL_MAX) || bound < -DBL_MAX);
        }
    }
    for (k = 0; bad == 0 && k < s->n_slot; k++) { /* a law is that of cells with photons */
        int32_t cell = s->cell_of_slot ? s->cell_of_slot[k] : k;
        int law = s->law ? s->law[cell] : s->law_of_all;
        if (s->lobe && s->lobe[cell] >= 0) continue;
        bad += s->precision == 4 ? !aomc_sky_is_sound_f32(s, cell, law) : !aomc_sky_is_sound_f64(s, cell, law);
    }
    return bad == 0 && (!s->perez_word || aomc_sky_are_bounded(s->sky, 11, DBL_MAX));
}

/* Whether every weight is a finite number, not negative, and the components follow each other up to the last cell. */
SKY_HOST int aomc_sky_check_weights(const aomc_sky_source *s) {
    uint64_t k, bad = 0;
    int32_t cell, end = 0;
    for (cell = 0; s->weights && cell < s->n_cell; cell++) {
        double weight = s->precision == 4 ? (double)((const float *)s->weights)[cell] : ((const double *)s->weights)[cell];
        bad += !(weight >= 0.0 && weight <= DBL_MAX);
    }
    for (k = 0; k < s->n_component; end = s->component_ends[k++]) bad += s->component_ends[k] <= end;
    return bad == 0 && (s->n_component == 0 || end == s->n_cell);
}

/* Whether the bins of every lobe lead to its cells, and its photons are shared out over them as `bin_proposals` says. */
SKY_HOST int aomc_sky_check_lobes(const aomc_sky_source *s, uint64_t n_lobe, uint64_t n_bin, uint64_t n_envelope) {
    uint64_t k, j, slot;
    if (s->lobe_ends[1] > (int64_t)n_lobe || n_envelope % 8 != 0) return 0;
    if (!aomc_sky_are_bounded(s->shapes, 9 * n_lobe, DBL_MAX) ||
        !aomc_sky_are_bounded(s->envelopes, n_envelope, DBL_MAX))
        return 0;
    for (j = 0; j < n_envelope; j += 8) {
        const double *e = s->envelopes + j;
        if (!(e[3] >= 1.0 && e[3] <= 65536.0 && e[4] >= 0.0 && e[4] <= 0.5 && e[7] > 0.0)) return 0;
    }
    for (k = 0; k < n_lobe; k++) {
        const uint64_t *range = s->ranges + 4 * k, *proposal = s->bin_proposals + 5 * k;
        uint64_t bits = range[1], size, n_cell = n_envelope / 8, n;
        double unit, line;
        if (bits < 1 || bits > 16 || proposal[4] != bits || range[0] > n_bin || range[2] >= n_cell) return 0;
        size = UINT64_C(1) << bits;
        if (size > n_bin - range[0]) return 0;
        for (j = 0; j < size; j++)
            if ((s->bins[range[0] + j] >> 16) >= n_cell - range[2]) return 0;
        if (proposal[1] > (UINT64_C(1) << 62) >> bits || proposal[2] >= size || proposal[3] >> (bits + 30) != 0) return 0;
        n = proposal[1] * size + proposal[2];
        unit = (double)(UINT64_C(1) << (bits + 30));
        line = n ? (double)size / (double)n : 0.0;
        if (s->bins_per_photon[2 * k] != line) return 0;
        if (s->bins_per_photon[2 * k + 1] != ((unit - (double)proposal[3]) / unit) * line - 9.31322574615478515625e-10) return 0;
    }
    for (slot = 0; slot < (uint64_t)s->n_slot; slot++) {
        int32_t cell = s->cell_of_slot ? s->cell_of_slot[slot] : (int32_t)slot, lobe = s->lobe[cell];
        uint64_t before = aomc_sky_before(s, slot), n = aomc_sky_before(s, slot + 1) - before;
        const uint64_t *proposal = s->bin_proposals + 5 * (uint64_t)(lobe < 0 ? 0 : lobe);
        if (lobe < -1 || lobe >= (int64_t)n_lobe) return 0;
        if (lobe >= 0 && n && (proposal[0] != before || (proposal[1] << proposal[4]) + proposal[2] != n)) return 0;
    }
    for (k = 0; k < (uint64_t)s->n_cell; k++)
        if (s->lobe[k] < -1 || s->lobe[k] >= (int64_t)n_lobe) return 0;
    return 1;
}

/* 0, or what is wrong with the band of a replicate. */
SKY_HOST int aomc_sky_check_band(const aomc_sky_file *file, int32_t band, int32_t replicate, aomc_sky_source *s) {
    aomc_sky_section t[AOMC_SKY_LAST_KIND + 1];
    uint32_t n_replicates;
    int code = aomc_sky_open_band(file, band, replicate, file->bytes, s, t);
    if (code != 0 || s->n == 0) return code;
    if (t[AOMC_SKY_REPLICATE_COUNT].at) {
        memcpy(&n_replicates, t[AOMC_SKY_REPLICATE_COUNT].at, 4);
        if (n_replicates != (uint32_t)file->n_replicates) return AOMC_SKY_DIRECTORY;
    }
    if (!aomc_sky_check_slots(s)) return AOMC_SKY_TABLE;
    if (s->lobe && !aomc_sky_check_lobes(s, t[AOMC_SKY_RANGES].count / 4, t[AOMC_SKY_BINS].count,
                       t[AOMC_SKY_ENVELOPES].count))
        return AOMC_SKY_TABLE;
    if (!aomc_sky_check_cells(s, t[AOMC_SKY_WORDS].count) || !aomc_sky_check_weights(s)) return AOMC_SKY_TABLE;
    return aomc_sky_witness(s);
}

/* Take a file that is in memory, aligned to 8 bytes: from mmap, MPI_Bcast, an array. Nothing is copied. */
AOMC_SKY_HOST_API int aomc_sky_view(const void *bytes, uint64_t size, aomc_sky_file *file) {
    const unsigned char *from = (const unsigned char *)bytes;
    aomc_sky_source source;
    uint64_t word, n_replicates;
    uint32_t layout, precision, n_bands;
    int32_t band, replicate;
    int code = 0;
    if (!file) return AOMC_SKY_NULL;
    memset(file, 0, sizeof *file);
    if (!bytes || (uintptr_t)bytes % 8 != 0) return AOMC_SKY_NULL;
    if (size < 8 || memcmp(from, "AOMC-SKY", 8) != 0) return AOMC_SKY_NOT_OURS;
    if (size < AOMC_SKY_HEAD_BYTES) return AOMC_SKY_SIZE;
    memcpy(&layout, from + 8, 4);
    memcpy(&precision, from + 12, 4);
    memcpy(&word, from + 32, 8);
    if (layout != AOMC_SKY_LAYOUT) return AOMC_SKY_NEWER;
    if (word != size || size % 8 != 0) return AOMC_SKY_SIZE;
    memcpy(&word, from + 40, 8);
    if (word != aomc_sky_checksum(bytes, size)) return AOMC_SKY_CHECKSUM;
    if (!aomc_sky_is_nearest()) return AOMC_SKY_ARITHMETIC; /* before tables are compared with sums */
    if (memcmp(from + 16, AOMC_SKY_STREAM "\0\0\0\0\0", 16) != 0) return AOMC_SKY_STREAMS;
    memcpy(&n_bands, from + 48, 4);
    memcpy(&word, from + 56, 8);
    memcpy(&n_replicates, from + 128, 8);
    if (n_replicates == 0) n_replicates = 1; /* an older file */
    if ((precision != 4 && precision != 8) || word % 64 != 0 || word > size || n_bands > 0x7FFFFFFF ||
        n_replicates > AOMC_SKY_MOST_REPLICATES || n_bands * n_replicates > (size - word) / (8 * AOMC_SKY_RECORD_WORDS))
        return AOMC_SKY_DIRECTORY;
    file->bytes = from, file->size = size, file->n_bands = (int32_t)n_bands, file->precision = (int32_t)precision;
    file->n_replicates = (int32_t)n_replicates;
    memcpy(file->plan_sha256, from + 64, 64);
    for (replicate = 0; replicate < file->n_replicates && code == 0; replicate++)
        for (band = 0; band < file->n_bands && code == 0; band++)
            code = aomc_sky_check_band(file, band, replicate, &source);
    if (code != 0) memset(file, 0, sizeof *file);
    return code;
}

/* Read a file. `unload` frees it. */
AOMC_SKY_HOST_API int aomc_sky_load(const char *path, aomc_sky_file *file) {
    FILE *stream;
    void *bytes = NULL;
    long size = -1;
    int code = AOMC_SKY_NO_FILE;
    if (!file) return AOMC_SKY_NULL;
    memset(file, 0, sizeof *file);
    if (!path) return AOMC_SKY_NULL;
    stream = fopen(path, "rb");
    if (!stream) return AOMC_SKY_NO_FILE;
    if (fseek(stream, 0, SEEK_END) == 0 && (size = ftell(stream)) >= 0 && size < LONG_MAX &&
        fseek(stream, 0, SEEK_SET) == 0) {
        bytes = malloc(size > 0 ? (size_t)size : 1);
        if (!bytes) code = AOMC_SKY_NO_MEMORY;
        else if (fread(bytes, 1, (size_t)size, stream) == (size_t)size)
            code = aomc_sky_view(bytes, (uint64_t)size, file);
    }
    fclose(stream);
    if (code == 0) file->is_owned = 1;
    else free(bytes);
    return code;
}

/* Free what `load` took. Sources of the file must not be used any more. */
AOMC_SKY_HOST_API void aomc_sky_unload(aomc_sky_file *file) {
    if (!file) return;
    if (file->is_owned) free((void *)(uintptr_t)file->bytes);
    memset(file, 0, sizeof *file);
}

/* A code, and a source without photons. */
SKY_HOST int aomc_sky_refused(int code, aomc_sky_source *source) {
    memset(source, 0, sizeof *source);
    return code;
}

/* Band `band`, from 0, of replicate `replicate`, from 0, whose bytes are copied to `device_bytes`, for use there, by a
 * host that counts each photon with its weight. The weights of a file that has none are 1. */
AOMC_SKY_HOST_API int aomc_sky_weighted_replicate_at(const aomc_sky_file *file, int32_t band, int32_t replicate,
    const void *device_bytes, aomc_sky_source *source) {
    aomc_sky_section t[AOMC_SKY_LAST_KIND + 1];
    if (!file || !file->bytes || !device_bytes || !source) return AOMC_SKY_NULL;
    if (band < 0 || band >= file->n_bands || replicate < 0 || replicate >= file->n_replicates)
        return aomc_sky_refused(AOMC_SKY_NO_BAND, source);
    return aomc_sky_open_band(file, band, replicate, device_bytes, source, t);
}

AOMC_SKY_HOST_API int aomc_sky_weighted_replicate(
    const aomc_sky_file *file, int32_t band, int32_t replicate, aomc_sky_source *source) {
    return aomc_sky_weighted_replicate_at(file, band, replicate, file ? file->bytes : NULL, source);
}

/* The same for a host that counts all photons alike: a band with weights has a code, AOMC_SKY_WEIGHTS, and no photons. */
AOMC_SKY_HOST_API int aomc_sky_replicate(
    const aomc_sky_file *file, int32_t band, int32_t replicate, aomc_sky_source *source) {
    int code = aomc_sky_weighted_replicate(file, band, replicate, source);
    return code == 0 && source->weights ? aomc_sky_refused(AOMC_SKY_WEIGHTS, source) : code;
}

/* Band `band`, from 0, of a file without replicates; one with them has a code, AOMC_SKY_REPLICATES, and no photons. */
AOMC_SKY_HOST_API int aomc_sky_weighted_band_at(
    const aomc_sky_file *file, int32_t band, const void *device_bytes, aomc_sky_source *source) {
    int code = aomc_sky_weighted_replicate_at(file, band, 0, device_bytes, source);
    return code == 0 && file->n_replicates > 1 ? aomc_sky_refused(AOMC_SKY_REPLICATES, source) : code;
}

AOMC_SKY_HOST_API int aomc_sky_band_at(
    const aomc_sky_file *file, int32_t band, const void *device_bytes, aomc_sky_source *source) {
    int code = aomc_sky_weighted_band_at(file, band, device_bytes, source);
    return code == 0 && source->weights ? aomc_sky_refused(AOMC_SKY_WEIGHTS, source) : code;
}

AOMC_SKY_HOST_API int aomc_sky_weighted_band(const aomc_sky_file *file, int32_t band, aomc_sky_source *source) {
    return aomc_sky_weighted_band_at(file, band, file ? file->bytes : NULL, source);
}

AOMC_SKY_HOST_API int aomc_sky_band(const aomc_sky_file *file, int32_t band, aomc_sky_source *source) {
    return aomc_sky_band_at(file, band, file ? file->bytes : NULL, source);
}

/* What a code says. */
AOMC_SKY_HOST_API const char *aomc_sky_message(int64_t code) {
    switch (code) {
    case AOMC_SKY_NO_FILE: return "the file cannot be read";
    case AOMC_SKY_NO_MEMORY: return "there is no memory for the file";
    case AOMC_SKY_NULL: return "a pointer is NULL, or the bytes do not begin at a multiple of 8";
    case AOMC_SKY_NOT_OURS: return "this is not a source file of aomc-sky";
    case AOMC_SKY_NEWER: return "the file is of a newer layout: take aomc_sky.h of the version that wrote it";
    case AOMC_SKY_STREAMS:
        return "the file has other photons than this aomc_sky.h gives: write it again, or take the "
               "header of the version that wrote it";
    case AOMC_SKY_SIZE: return "the file is cut off, or longer than it says";
    case AOMC_SKY_CHECKSUM: return "the file was changed or damaged after it was written";
    case AOMC_SKY_DIRECTORY: return "a section of the file lies outside of it, or has another length than it should";
    case AOMC_SKY_TABLE: return "a number in a table of the file is out of its bounds";
    case AOMC_SKY_ARITHMETIC:
        return "this compiler or its flags give other bits than the file knows: leave out -ffast-math (or define "
               "AOMC_SKY_DECLARE_ONLY, and compile aomc_sky.c without it), contract no products (-ffp-contract=off, "
               "for nvcc -fmad=false), and round to nearest";
    case AOMC_SKY_NO_BAND: return "there is no such band";
    case AOMC_SKY_OTHER: return "the source has the other precision: call the function with or without _double";
    case AOMC_SKY_RANGE: return "start or count is negative";
    case AOMC_SKY_TRIALS: return "photons are refused again and again: the file is not one that aomc-sky wrote";
    case AOMC_SKY_WEIGHTS:
        return "the photons have weights: open the band with aomc_sky_weighted_band (a replicate with "
               "aomc_sky_weighted_replicate), and count each photon with its weight";
    case AOMC_SKY_UNITS: return "some of the sources have an irradiance and others have none: they have no common light";
    case AOMC_SKY_REPLICATES: return "the band has replicates, independent runs: open each with aomc_sky_replicate";
    default: return code >= 0 ? "no error" : "an unknown code";
    }
}

#if !defined(AOMC_SKY_FLAGS_OF_HOST) && !defined(__clang__) && !defined(__CUDACC__) && defined(__GNUC__)
#pragma GCC pop_options
#endif

/* The next particle of a stream: 1; 0 at its end, where the particle is left as it is; or a code. It copies numbers
 * alone, so it may have the flags of a host, and is inlined there: a call would take half as long again. */
SKY_NEXT int aomc_sky_next(aomc_sky_stream *stream, aomc_sky_particle *particle) {
    int32_t k;
    if (!stream || !particle) return AOMC_SKY_NULL;
    if (stream->next == stream->made) {
        int code = stream->at < stream->to ? aomc_sky_make_particles(stream) : 0;
        if (code <= 0) return code;
    }
    k = stream->next++;
    stream->at++;
    if (stream->precision == 4) {
        const float *f = &stream->column.f32[0][k];
        particle->ux = (double)f[0];
        particle->uy = (double)f[AOMC_SKY_BUFFER];
        particle->uz = (double)f[2 * AOMC_SKY_BUFFER];
        particle->x = stream->has_positions ? (double)f[4 * AOMC_SKY_BUFFER] : 0.0;
        particle->y = stream->has_positions ? (double)f[5 * AOMC_SKY_BUFFER] : 0.0;
    } else {
        const double *f = &stream->column.f64[0][k];
        particle->ux = f[0];
        particle->uy = f[AOMC_SKY_BUFFER];
        particle->uz = f[2 * AOMC_SKY_BUFFER];
        particle->x = stream->has_positions ? f[4 * AOMC_SKY_BUFFER] : 0.0;
        particle->y = stream->has_positions ? f[5 * AOMC_SKY_BUFFER] : 0.0;
    }
    particle->weight = stream->light[k];
    particle->index = stream->index - stream->made + k;
    particle->band = stream->band;
    particle->patch = stream->patch[k];
    particle->component = stream->component[k];
    particle->reserve = 0;
    return 1;
}

#endif /* AOMC_SKY_DECLARE_ONLY */
#ifdef __cplusplus
}
#endif
#undef SKY_ALONE
#undef SKY_APART
#undef SKY_AVX
#undef SKY_AVX2
#undef SKY_BLOCK
#undef SKY_CHUNK
#undef SKY_COLUMN
#undef SKY_GROUP
#undef SKY_DRAW_ACCEPT
#undef SKY_FN
#undef SKY_FORMULA
#undef SKY_HOST
#undef SKY_LAST_TRIAL
#undef SKY_LINES
#undef SKY_LN2_HIGH
#undef SKY_LN2_LOW
#undef SKY_LOW
#undef SKY_NEXT
#undef SKY_NEON
#undef SKY_ON_DEVICE
#undef SKY_PIECE
#undef SKY_SSE2
#undef SKY_STRETCH
#undef SKY_UNKNOWN
#endif /* AOMC_SKY_H */

#else /* AOMC_SKY_PRECISION: what follows is read once for float32 and once for float64 */

/* ---- kernels/arithmetic/elementary.py ---- */

/* unit */
SKY_FORMULA SKY_F SKY_(unit)(uint64_t bits) {
#if AOMC_SKY_PRECISION == 4
    return (float)(int32_t)(bits >> 40) * 5.9604644775390625e-08f;
#else
    return aomc_sky_uniform(bits);
#endif
}

/* sincos_quarter */
SKY_FORMULA void SKY_(sincos_quarter)(SKY_F r, SKY_F *sine, SKY_F *cosine) {
    SKY_F t = r * r, s, c;
#if AOMC_SKY_PRECISION == 4
    s = (float)-0.004602149128913879 * t + (float)0.07968021929264069;
    s = s * t + (float)-0.6459634900093079;
    s = s * t + (float)1.5707963705062866;
    c = (float)0.0009067399078048766 * t + (float)-0.02086152881383896;
    c = c * t + (float)0.253669410943985;
    c = c * t + (float)-1.2337005138397217;
#else
    s = 5.633933781537854e-08 * t + -3.59864335298231e-06;
    s = s * t + 0.0001604411507421909;
    s = s * t + -0.004681754132340976;
    s = s * t + 0.07969262624604301;
    s = s * t + -0.6459640975062443;
    s = s * t + 1.5707963267948966;
    c = -6.329396344967424e-09 * t + 4.710678405505227e-07;
    c = c * t + -2.5202039028029178e-05;
    c = c * t + 0.0009192602745468447;
    c = c * t + -0.020863480763340773;
    c = c * t + 0.2536695079010478;
    c = c * t + -1.2337005501361697;
#endif
    *sine = s * r;
    *cosine = c * t + (SKY_F)1;
}

/* sincos_narrow */
SKY_FORMULA void SKY_(sincos_narrow)(SKY_F r, SKY_F *sine, SKY_F *cosine) {
    SKY_F t = r * r, s, c;
#if AOMC_SKY_PRECISION == 4
    s = (float)-0.6459640975062463 * t + (float)1.5707963267948966;
    c = (float)-1.2337005501361697;
#else
    s = -0.004681754135318688 * t + 0.07969262624616705;
    s = s * t + -0.6459640975062463;
    s = s * t + 1.5707963267948966;
    c = -0.02086348076335296 * t + 0.25366950790104803;
    c = c * t + -1.2337005501361697;
#endif
    *sine = s * r;
    *cosine = c * t + (SKY_F)1;
}

/* sincos_turned_any before the turn, with turned_by_quarters */
SKY_FORMULA void SKY_(sincos_any)(SKY_F half_width, SKY_F x, SKY_F *sine, SKY_F *cosine) {
    SKY_F turns = SKY_RINT(x), s0, c0, s1, c1, s, c;
    int32_t quarter = (int32_t)turns, is_narrow = half_width <= (SKY_F)(1.0 / 60.0);
    SKY_(sincos_quarter)(x - turns, &s0, &c0);
    SKY_(sincos_narrow)(x - turns, &s1, &c1);
    s0 = is_narrow ? s1 : s0;
    c0 = is_narrow ? c1 : c0;
    s = quarter & 1 ? c0 : s0;
    c = quarter & 1 ? s0 : c0;
    *sine = quarter & 2 ? -s : s;
    *cosine = (quarter + 1) & 2 ? -c : c;
}

/* sincos_turned, sincos_turned_narrow or sincos_turned_any: the angle of the cell's centre has the sine t0, cosine
 * t1 */
SKY_FORMULA void SKY_(turned)(int kernel, SKY_F t0, SKY_F t1, SKY_F half_width, SKY_F v, SKY_F *sine, SKY_F *cosine) {
    SKY_F x = half_width * (v + v - (SKY_F)1), s, c;
    if (kernel == AOMC_SKY_NARROW) SKY_(sincos_narrow)(x, &s, &c);
    else if (kernel == AOMC_SKY_QUARTER) SKY_(sincos_quarter)(x, &s, &c);
    else SKY_(sincos_any)(half_width, x, &s, &c);
    *sine = t0 * c + t1 * s;
    *cosine = t1 * c - t0 * s;
}

/* ---- kernels/cells/laws.py ---- */

/* sloped */
SKY_FORMULA SKY_F SKY_(on_slope)(SKY_F u, int32_t steps) {
    const SKY_F one = 1, below_one = (SKY_F)(AOMC_SKY_PRECISION == 4 ? 0.999999940395355224609375
                                                                     : 0.99999999999999988897769753748434596);
    SKY_F slope = (SKY_F)steps * (SKY_F)9.31322574615478515625e-10, rest = one - slope, x;
    x = (u + u) / (rest + SKY_(sqrt)(rest * rest + (SKY_F)4 * slope * u));
    return x < below_one ? x : below_one;
}

/* from_mu2 and from_mu: p holds h0, h1, h2, h3, t0, t1 */
SKY_FORMULA void SKY_(from_mu2)(const SKY_F *p, SKY_F u, SKY_F sine, SKY_F cosine, SKY_F *out) {
    SKY_F radius = SKY_(sqrt)(p[0] + p[1] * u);
    out[0] = -(radius * cosine);
    out[1] = -(radius * sine);
    out[2] = -SKY_(sqrt)(p[2] + p[1] * ((SKY_F)1 - u));
}

SKY_FORMULA void SKY_(from_mu)(const SKY_F *p, SKY_F u, SKY_F sine, SKY_F cosine, SKY_F *out) {
    const SKY_F one = 1;
    SKY_F mu = p[2] + p[1] * (one - u), radius = SKY_(sqrt)((p[0] + p[1] * u) * (one + mu));
    out[0] = -(radius * cosine);
    out[1] = -(radius * sine);
    out[2] = -mu;
}

/* disc but for the root of the square of z, which it returns; `root` is that of u. x and y hold the cosine and the sine of
 * the angle around the axis, and take x and y of the photon. */
SKY_FORMULA SKY_F SKY_(disc)(
    SKY_F h0, SKY_F h1, SKY_F h2, SKY_F h3, SKY_F t0, SKY_F t1, SKY_F u, SKY_F root, SKY_F *x, SKY_F *y) {
    const SKY_F one = 1;
    SKY_F along = h2 * root * *x, across = h2 * root * *y, far = h3 * h0 + along * h1, height = h3 * h1 - along * h0;
    *x = -(far * t1 - across * t0);
    *y = -(far * t0 + across * t1);
    return height * height + h2 * h2 * (one - u);
}

/* disc_at_horizon_trial */
SKY_FORMULA int SKY_(horizon_trial)(const SKY_F *p, SKY_F u, SKY_F v, SKY_F *out) {
    const SKY_F one = 1;
    SKY_F s, c, dx, dy, dz, sine = SKY_(sqrt)(one - p[3] * p[3]), mu2 = p[0] * (one - u), mu = SKY_(sqrt)(mu2),
                            far = SKY_(sqrt)(one - mu2);
    SKY_(turned)(AOMC_SKY_ANY_WIDTH, (SKY_F)0, one, p[1], v, &s, &c);
    dx = far * c - sine;
    dy = far * s;
    dz = mu - p[3];
    out[0] = -(far * (c * p[5] - s * p[4]));
    out[1] = -(far * (c * p[4] + s * p[5]));
    out[2] = -mu;
    return dx * dx + dy * dy + dz * dz <= p[2];
}

/* ---- emission/kernels/emit.py ---- */

/* direction_of; returns how many trials it took beside the first one */
SKY_FN uint32_t SKY_(direction)(
    const aomc_sky_source *s, int law, const SKY_F *p, SKY_F u, SKY_F v, uint64_t rank, SKY_F *out) {
    SKY_F sine, cosine;
    uint64_t a, b;
    uint32_t trial;
    if (law == AOMC_SKY_DISC) {
        SKY_(turned)(AOMC_SKY_ANY_WIDTH, 0, 1, 2, v, out + 1, out);
        out[2] = SKY_(disc)(p[0], p[1], p[2], p[3], p[4], p[5], u, SKY_(sqrt)(u), out, out + 1);
        out[2] = -SKY_(sqrt)(out[2]);
        return 0;
    }
    if (law == AOMC_SKY_DISC_AT_HORIZON) {
        for (trial = 1; !SKY_(horizon_trial)(p, u, v, out) && trial < SKY_LAST_TRIAL; trial++) {
            aomc_sky_pair(s->placement_key, rank, s->band, trial, &a, &b);
            u = SKY_(unit)(a);
            v = SKY_(unit)(b);
        }
        return trial - 1;
    }
    if (p[3] <= (SKY_F)(1.0 / 60.0)) SKY_(turned)(AOMC_SKY_NARROW, p[4], p[5], p[3], v, &sine, &cosine);
    else if (p[3] <= (SKY_F)0.5) SKY_(turned)(AOMC_SKY_QUARTER, p[4], p[5], p[3], v, &sine, &cosine);
    else SKY_(turned)(AOMC_SKY_ANY_WIDTH, p[4], p[5], p[3], v, &sine, &cosine);
    if (law == AOMC_SKY_CELL_MU) SKY_(from_mu)(p, u, sine, cosine, out);
    else SKY_(from_mu2)(p, u, sine, cosine, out);
    return 0;
}

/* cell_of_table and ring_offset_of_table: parameters h0, h1, h2, h3, t0, t1 of a cell; the ring offset is returned */
SKY_FORMULA uint64_t SKY_(cell)(const aomc_sky_source *s, int32_t cell, SKY_F *p) {
    uint64_t place = s->place[cell], ring_offset;
    SKY_F tail[4];
    memcpy(p, s->words + (place >> 32), 4 * sizeof *p);
    memcpy(tail, s->words + (place & SKY_LOW), sizeof tail);
#if AOMC_SKY_PRECISION == 4
    {
        uint32_t half;
        memcpy(&half, p + 3, 4);
        ring_offset = (uint64_t)half << 32;
    }
#else
    memcpy(&ring_offset, p + 3, 8);
#endif
    p[3] = tail[2], p[4] = tail[0], p[5] = tail[1];
    return ring_offset;
}

/* Whether photons at both ends of a cell have unit vectors that travel down. Those between them have, too: the roots are
 * of sums that are linear in u. */
SKY_FN int SKY_(is_sound)(const aomc_sky_source *s, int32_t cell, int law) {
    const SKY_F one = 1, widest = (SKY_F)(s->azimuth_kernel == AOMC_SKY_NARROW ? 1.0 / 60.0 : 0.5);
    SKY_F p[6];
    int end;
    SKY_(cell)(s, cell, p);
    if (law == s->law_of_all && s->azimuth_kernel <= AOMC_SKY_QUARTER && !(p[3] <= widest)) return 0;
    for (end = 0; end < 2; end++) {
        SKY_F u = end ? SKY_(unit)(UINT64_MAX) : 0, out[3], excess;
        if (law == AOMC_SKY_DISC_AT_HORIZON) SKY_(horizon_trial)(p, u, u, out);
        else SKY_(direction)(s, law, p, u, u, 0, out);
        excess = out[0] * out[0] + out[1] * out[1] + out[2] * out[2] - one;
        if (!(excess < (SKY_F)1e-4 && excess > (SKY_F)-1e-4 && out[2] <= 0)) return 0;
    }
    return 1;
}

/* ---- skies/perez/kernels ---- */

/* tilted: moves (u, v) and returns J */
SKY_FORMULA SKY_F SKY_(tilted)(SKY_F *u, SKY_F *v, uint32_t cell_word) {
    const SKY_F one = 1, step = (SKY_F)0.00048828125;
    SKY_F tilt_u = (SKY_F)((int32_t)cell_word >> 22) * step, rest_u = one - *u, jacobian;
    SKY_F tilt_v = (SKY_F)((int32_t)(cell_word << 10) >> 22) * step, rest_v = one - *v;
    jacobian = (one + tilt_u * (rest_u - *u)) * (one + tilt_v * (rest_v - *v));
    *u = *u * (one + tilt_u * rest_u);
    *v = *v * (one + tilt_v * rest_v);
    return jacobian;
}

/* further_trials: the direction after the trial `trial` and as many more as it takes; the last one */
SKY_FN uint32_t SKY_(further)(
    const aomc_sky_source *s, uint32_t trial, const SKY_F *p, int32_t cell, uint64_t rank, SKY_F *out) {
    for (; trial < SKY_LAST_TRIAL; trial++) {
        uint64_t a, b, word;
        SKY_F u, v, jacobian;
        aomc_sky_later(s->placement_key, rank, s->band, trial, &a, &b, &word);
        u = SKY_(unit)(a);
        v = SKY_(unit)(b);
        jacobian = SKY_(tilted)(&u, &v, s->perez_word[cell]);
        SKY_(direction)(s, AOMC_SKY_CELL_MU2, p, u, v, rank, out);
        if (!aomc_sky_is_rejected(out[0], out[1], out[2], jacobian, word, s->perez_bound[cell], s->sky)) break;
    }
    return trial;
}

/* ---- emission/kernels/sampler.py ---- */

/* photon_at but for the common case: the direction of a photon in a cell, by its rank. `inside` is NULL, or takes
 * unrounded values for witnesses. */
SKY_APART void SKY_(photon_of_rank)(const aomc_sky_source *s, uint64_t rank, int32_t cell, SKY_F *out, double *inside) {
    uint64_t a, b, ring_offset;
    SKY_F p[6], u, v, jacobian = 1;
    ring_offset = SKY_(cell)(s, cell, p);
    if (s->by_philox) {
        aomc_sky_pair(s->placement_key, rank, s->band, 0, &a, &b);
        ring_offset = 0;
    } else {
        a = s->shifts[0] + rank * s->steps[0];
        b = s->shifts[1] + rank * s->steps[1];
    }
    if (s->lobe && s->lobe[cell] >= 0) {
        double lobe_direction[3];
        aomc_sky_lobe_photon(s, s->lobe[cell], a, b, rank, lobe_direction);
        if (inside) memcpy(inside, lobe_direction, sizeof lobe_direction);
        out[0] = (SKY_F)lobe_direction[0], out[1] = (SKY_F)lobe_direction[1], out[2] = (SKY_F)lobe_direction[2];
        return;
    }
    u = SKY_(unit)(a);
    v = SKY_(unit)(b + ring_offset);
    if (s->slopes) {
        u = SKY_(on_slope)(u, (int32_t)(s->slopes[cell] >> 32));
        v = SKY_(on_slope)(v, (int32_t)(s->slopes[cell] & SKY_LOW));
    }
    if (s->perez_word) jacobian = SKY_(tilted)(&u, &v, s->perez_word[cell]);
    SKY_(direction)(s, s->law ? s->law[cell] : s->law_of_all, p, u, v, rank, out);
    if (s->perez_word) { /* taken_or_replaced */
        uint64_t word = aomc_sky_decision(s->by_philox, s, rank, 0);
        if (!aomc_sky_is_at_once(word, s->perez_word[cell]) &&
            aomc_sky_is_rejected(out[0], out[1], out[2], jacobian, word, s->perez_bound[cell], s->sky))
            SKY_(further)(s, 1, p, cell, rank, out);
        if (inside && s->perez_bound[cell] >= 0.0) inside[0] = aomc_sky_luminance(out[0], out[1], out[2], s->sky);
    }
}

/* the direction of a photon in a cell uniform in mu^2, by the two words of its place */
SKY_FORMULA void SKY_(of_words)(const aomc_sky_source *s, const SKY_F *p, uint64_t a, uint64_t b, SKY_F *out) {
    SKY_F v = SKY_(unit)(b), sine, cosine;
    if (s->azimuth_kernel == AOMC_SKY_NARROW) SKY_(turned)(AOMC_SKY_NARROW, p[4], p[5], p[3], v, &sine, &cosine);
    else SKY_(turned)(AOMC_SKY_QUARTER, p[4], p[5], p[3], v, &sine, &cosine);
    SKY_(from_mu2)(p, SKY_(unit)(a), sine, cosine, out);
}

/* photon_at: the direction of photon i; returns its cell */
SKY_FORMULA int32_t SKY_(photon)(const aomc_sky_source *s, uint64_t i, SKY_F *out, double *inside) {
    uint64_t rank = aomc_sky_rank(s, i), ring_offset;
    uint32_t slot = aomc_sky_slot(s, rank);
    int32_t cell = s->cell_of_slot ? s->cell_of_slot[slot] : (int32_t)slot;
    SKY_F p[6];
    if (!s->is_common || cell == s->disc_cell) {
        SKY_F other[3]; /* so that the short way needs no memory */
        SKY_(photon_of_rank)(s, rank, cell, other, inside);
        out[0] = other[0], out[1] = other[1], out[2] = other[2];
        return cell;
    }
    ring_offset = SKY_(cell)(s, cell, p);
    if (s->by_philox) {
        aomc_sky_words words = aomc_sky_pair_apart(s->placement_key, rank, s->band);
        SKY_(of_words)(s, p, words.a, words.b, out);
        return cell;
    }
    SKY_(of_words)(s, p, s->shifts[0] + rank * s->steps[0], s->shifts[1] + rank * s->steps[1] + ring_offset, out);
    return cell;
}

/* ---- a block of photons: emission/kernels/emit.py. Short loops over columns, which compilers make vectors of ---- */

/* Columns of a block. Parameters: h0, h1, h2, ring offset, t0, t1, h3; their columns are SKY_COLUMN apart, which is no power
 * of two, for such ones would share lines of the cache. */
typedef struct SKY_(columns) {
    SKY_F p[8 * SKY_COLUMN], u[SKY_BLOCK], v[SKY_BLOCK];
    SKY_F jacobian[SKY_BLOCK];
    uint64_t rank[SKY_BLOCK], place[SKY_BLOCK];
    int32_t cell[SKY_COLUMN];
    uint32_t chosen[SKY_BLOCK], cell_word[SKY_BLOCK];
} SKY_LINES SKY_(columns);

/* cell_of_photon */
SKY_FORMULA void SKY_(parameters)(const SKY_(columns) *c, uint64_t j, SKY_F *p) {
    const SKY_F *of = c->p + j;
    p[0] = of[0], p[1] = of[SKY_COLUMN], p[2] = of[2 * SKY_COLUMN];
    p[3] = of[6 * SKY_COLUMN], p[4] = of[4 * SKY_COLUMN], p[5] = of[5 * SKY_COLUMN];
}

/* The loop of `_cells` for one width and one law, for at most SKY_PIECE photons */
SKY_FORMULA void SKY_(cells_of_piece)(int kernel, uint64_t m, const SKY_F *p, const SKY_F *u, const SKY_F *v,
    SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y, SKY_F *SKY_ALONE z) {
    const SKY_F one = 1;
    SKY_LINES SKY_F radius[SKY_PIECE], mu[SKY_PIECE], sine[SKY_PIECE], cosine[SKY_PIECE];
    uint64_t j;
    for (j = 0; j < m; j++) {
        SKY_F h0 = p[j], h1 = p[SKY_COLUMN + j], h2 = p[2 * SKY_COLUMN + j], h3 = p[6 * SKY_COLUMN + j];
        SKY_(turned)(kernel, p[4 * SKY_COLUMN + j], p[5 * SKY_COLUMN + j], h3, v[j], sine + j, cosine + j);
        mu[j] = h2 + h1 * (one - u[j]);
        radius[j] = kernel == AOMC_SKY_IN_MU ? (h0 + h1 * u[j]) * (one + mu[j]) : h0 + h1 * u[j];
    }
    SKY_(roots)(m, radius);
    if (kernel != AOMC_SKY_IN_MU) SKY_(roots)(m, mu);
    for (j = 0; j < m; j++) {
        x[j] = -(radius[j] * cosine[j]);
        y[j] = -(radius[j] * sine[j]);
        z[j] = -mu[j];
    }
}

/* In pieces, so that a processor takes the roots of one while it multiplies for the next. */
SKY_FORMULA void SKY_(cells_of_kernel)(int kernel, uint64_t m, const SKY_F *p, const SKY_F *u, const SKY_F *v,
    SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y, SKY_F *SKY_ALONE z) {
    uint64_t j;
    for (j = 0; j + SKY_PIECE <= m; j += SKY_PIECE)
        SKY_(cells_of_piece)(kernel, SKY_PIECE, p + j, u + j, v + j, x + j, y + j, z + j);
    SKY_(cells_of_piece)(kernel, m - j, p + j, u + j, v + j, x + j, y + j, z + j);
}

SKY_FN void SKY_(cells)(int kernel, uint64_t m, const SKY_F *p, const SKY_F *u, const SKY_F *v, SKY_F *x, SKY_F *y, SKY_F *z) {
    if (kernel == AOMC_SKY_NARROW) SKY_(cells_of_kernel)(AOMC_SKY_NARROW, m, p, u, v, x, y, z);
    else if (kernel == AOMC_SKY_QUARTER) SKY_(cells_of_kernel)(AOMC_SKY_QUARTER, m, p, u, v, x, y, z);
    else if (kernel == AOMC_SKY_ANY_WIDTH) SKY_(cells_of_kernel)(AOMC_SKY_ANY_WIDTH, m, p, u, v, x, y, z);
    else SKY_(cells_of_kernel)(AOMC_SKY_IN_MU, m, p, u, v, x, y, z);
}

/* kernels/cells/columns.py: rows of four numbers become columns; a place names the words where its two rows begin */
SKY_FORMULA void SKY_(turn_rows)(
    int shift, uint64_t m, const uint64_t *words, const uint64_t *place, SKY_F *SKY_ALONE to) {
    uint64_t j = 0;
#define SKY_ROW(k) ((const SKY_F *)(const void *)(words + (uint32_t)(place[j + (k)] >> shift)))
#if AOMC_SKY_PRECISION == 4 && (defined(SKY_AVX) || defined(SKY_SSE2))
    for (; j + 4 <= m; j += 4) {
        __m128 a = _mm_loadu_ps(SKY_ROW(0)), b = _mm_loadu_ps(SKY_ROW(1));
        __m128 c = _mm_loadu_ps(SKY_ROW(2)), d = _mm_loadu_ps(SKY_ROW(3));
        __m128 ab = _mm_unpacklo_ps(a, b), cd = _mm_unpacklo_ps(c, d);
        _mm_storeu_ps(to + j, _mm_movelh_ps(ab, cd));
        _mm_storeu_ps(to + SKY_COLUMN + j, _mm_movehl_ps(cd, ab));
        ab = _mm_unpackhi_ps(a, b), cd = _mm_unpackhi_ps(c, d);
        _mm_storeu_ps(to + 2 * SKY_COLUMN + j, _mm_movelh_ps(ab, cd));
        _mm_storeu_ps(to + 3 * SKY_COLUMN + j, _mm_movehl_ps(cd, ab));
    }
#elif AOMC_SKY_PRECISION == 8 && (defined(SKY_AVX) || defined(SKY_SSE2))
#ifdef SKY_AVX
    for (; j + 4 <= m; j += 4) {
        __m256d a = _mm256_loadu_pd(SKY_ROW(0)), b = _mm256_loadu_pd(SKY_ROW(1));
        __m256d c = _mm256_loadu_pd(SKY_ROW(2)), d = _mm256_loadu_pd(SKY_ROW(3));
        __m256d ab = _mm256_unpacklo_pd(a, b), cd = _mm256_unpacklo_pd(c, d);
        _mm256_storeu_pd(to + j, _mm256_permute2f128_pd(ab, cd, 0x20));
        _mm256_storeu_pd(to + 2 * SKY_COLUMN + j, _mm256_permute2f128_pd(ab, cd, 0x31));
        ab = _mm256_unpackhi_pd(a, b), cd = _mm256_unpackhi_pd(c, d);
        _mm256_storeu_pd(to + SKY_COLUMN + j, _mm256_permute2f128_pd(ab, cd, 0x20));
        _mm256_storeu_pd(to + 3 * SKY_COLUMN + j, _mm256_permute2f128_pd(ab, cd, 0x31));
    }
#endif
    for (; j + 2 <= m; j += 2) {
        __m128d a = _mm_loadu_pd(SKY_ROW(0)), b = _mm_loadu_pd(SKY_ROW(1));
        __m128d c = _mm_loadu_pd(SKY_ROW(0) + 2), d = _mm_loadu_pd(SKY_ROW(1) + 2);
        _mm_storeu_pd(to + j, _mm_unpacklo_pd(a, b));
        _mm_storeu_pd(to + SKY_COLUMN + j, _mm_unpackhi_pd(a, b));
        _mm_storeu_pd(to + 2 * SKY_COLUMN + j, _mm_unpacklo_pd(c, d));
        _mm_storeu_pd(to + 3 * SKY_COLUMN + j, _mm_unpackhi_pd(c, d));
    }
#endif
    for (; j < m; j++) {
        SKY_F row[4];
        memcpy(row, SKY_ROW(0), sizeof row);
        to[j] = row[0], to[SKY_COLUMN + j] = row[1], to[2 * SKY_COLUMN + j] = row[2], to[3 * SKY_COLUMN + j] = row[3];
    }
#undef SKY_ROW
}

/* _parameters_shuffled */
SKY_APART void SKY_(parameters_of_block)(uint64_t m, const uint64_t *words, const uint64_t *place, SKY_F *p) {
    SKY_(turn_rows)(32, m, words, place, p);
    SKY_(turn_rows)(0, m, words, place, p + 4 * SKY_COLUMN);
}

/* _in_order: a run of photons for each slot, written in whole groups, of which the next run writes the rest again */
SKY_FN void SKY_(gather_runs)(const aomc_sky_source *s, uint64_t start, uint64_t m, SKY_(columns) *c) {
    uint64_t slot = aomc_sky_slot(s, start), j = 0, end, lo, k, row;
    for (; j < m; j = end, slot++) {
        int32_t cell = s->cell_of_slot ? s->cell_of_slot[slot] : (int32_t)slot;
        uint64_t place = s->place[cell];
        SKY_F p[8];
        memcpy(p, s->words + (place >> 32), 4 * sizeof *p);
        memcpy(p + 4, s->words + (place & SKY_LOW), 4 * sizeof *p);
        end = aomc_sky_before(s, slot + 1) - start;
        end = end < m ? end : m;
        for (lo = j; lo < end; lo += SKY_GROUP) {
            for (k = 0; k < SKY_GROUP; k++) c->cell[lo + k] = cell;
            for (row = 0; row < 7; row++)
                for (k = 0; k < SKY_GROUP; k++) c->p[row * SKY_COLUMN + lo + k] = p[row];
        }
    }
}

/* ranks_of_block, _slots_shuffled, _parameters_shuffled */
SKY_APART void SKY_(gather)(const aomc_sky_source *s, uint64_t start, uint64_t m, SKY_(columns) *c) {
    const int32_t *cell_of_slot = s->cell_of_slot;
    uint64_t j;
    aomc_sky_ranks(s, start, m, c->rank);
    if (!s->is_shuffled) {
        SKY_(gather_runs)(s, start, m, c);
        return;
    }
    aomc_sky_slots(s, m, c->rank, c->cell);
    for (j = 0; cell_of_slot && j < m; j++) c->cell[j] = cell_of_slot[c->cell[j]];
    aomc_sky_places_of_cells(m, s->place, c->cell, c->place);
    SKY_(parameters_of_block)(m, s->words, c->place, c->p);
}

/* ring_offset_of_photon */
SKY_FORMULA uint64_t SKY_(ring_offset)(const SKY_F *p, uint64_t j) {
#if AOMC_SKY_PRECISION == 4
    uint32_t ring_offset;
    memcpy(&ring_offset, p + 3 * SKY_COLUMN + j, 4);
    return (uint64_t)ring_offset << 32;
#else
    uint64_t ring_offset;
    memcpy(&ring_offset, p + 3 * SKY_COLUMN + j, 8);
    return ring_offset;
#endif
}

/* _places_by_rank and _places_by_philox, with the slopes */
SKY_APART void SKY_(places)(const aomc_sky_source *s, uint64_t m, SKY_(columns) *c) {
    uint64_t j, shift_u = s->shifts[0], shift_v = s->shifts[1], step_u = s->steps[0], step_v = s->steps[1];
    if (s->by_philox) {
        uint64_t a[SKY_BLOCK], b[SKY_BLOCK];
        aomc_sky_pairs(s->placement_key, m, c->rank, s->band, 0, a, b);
        for (j = 0; j < m; j++) c->u[j] = SKY_(unit)(a[j]);
        for (j = 0; j < m; j++) c->v[j] = SKY_(unit)(b[j]);
    } else if (!s->has_wide_ranks)
        for (j = 0; j < m; j++) {
            uint32_t rank = (uint32_t)c->rank[j];
            c->u[j] = SKY_(unit)(shift_u + aomc_sky_times(rank, step_u));
            c->v[j] = SKY_(unit)(shift_v + aomc_sky_times(rank, step_v) + SKY_(ring_offset)(c->p, j));
        }
    else
        for (j = 0; j < m; j++) {
            c->u[j] = SKY_(unit)(shift_u + c->rank[j] * step_u);
            c->v[j] = SKY_(unit)(shift_v + c->rank[j] * step_v + SKY_(ring_offset)(c->p, j));
        }
    if (s->slopes)
        for (j = 0; j < m; j++) {
            uint64_t slopes = s->slopes[c->cell[j]];
            c->u[j] = SKY_(on_slope)(c->u[j], (int32_t)(slopes >> 32));
            c->v[j] = SKY_(on_slope)(c->v[j], (int32_t)(slopes & SKY_LOW));
        }
}

/* photons of the disc with the parameters p; x, y, z are other memory than u and v. Angles have a loop of their own: the
 * constants of one loop for all would take more registers than there are. */
SKY_APART void SKY_(discs_of_piece)(uint64_t m, const SKY_F *p, const SKY_F *u, const SKY_F *v,
    SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y, SKY_F *SKY_ALONE z) {
    SKY_LINES SKY_F root[SKY_PIECE];
    SKY_F h0 = p[0], h1 = p[1], h2 = p[2], h3 = p[3], t0 = p[4], t1 = p[5];
    uint64_t k;
    for (k = 0; k < m; k++) root[k] = u[k];
    SKY_(roots)(m, root);
    for (k = 0; k < m; k++) SKY_(turned)(AOMC_SKY_ANY_WIDTH, 0, 1, 2, v[k], y + k, x + k);
    for (k = 0; k < m; k++) z[k] = SKY_(disc)(h0, h1, h2, h3, t0, t1, u[k], root[k], x + k, y + k);
    SKY_(roots)(m, z);
    for (k = 0; k < m; k++) z[k] = -z[k];
}

SKY_FN void SKY_(discs)(
    uint64_t m, const SKY_F *p, const SKY_F *u, const SKY_F *v, SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y, SKY_F *SKY_ALONE z) {
    uint64_t j, n;
    for (j = 0; j < m; j += n) {
        n = m - j < SKY_PIECE ? m - j : SKY_PIECE;
        SKY_(discs_of_piece)(n, p, u + j, v + j, x + j, y + j, z + j);
    }
}

/* both values are read, whichever it is, so that clang makes vectors */
SKY_FORMULA SKY_F SKY_(either)(int is_first, SKY_F a, SKY_F b) { return is_first ? a : b; }

/* _one_disc: photons of the disc over those of the main law, which all other cells have */
SKY_APART void SKY_(one_disc)(
    const aomc_sky_source *s, uint64_t m, SKY_(columns) *c, SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y, SKY_F *SKY_ALONE z) {
    SKY_LINES SKY_F out[3][SKY_BLOCK];
    SKY_F p[6];
    int32_t cell = s->disc_cell;
    uint32_t n = 0;
    uint64_t j;
    for (j = 0; j < m; j++) n += c->cell[j] == cell;
    if (n == 0) return;
    (void)SKY_(cell)(s, cell, p);
    if (16 * (uint64_t)n > m) {
        SKY_(discs)(m, p, c->u, c->v, out[0], out[1], out[2]);
        for (j = 0; j < m; j++) {
            int is_own = c->cell[j] == cell;
            x[j] = SKY_(either)(is_own, out[0][j], x[j]);
            y[j] = SKY_(either)(is_own, out[1][j], y[j]);
            z[j] = SKY_(either)(is_own, out[2][j], z[j]);
        }
    } else
        for (j = 0; j < m; j++) {
            SKY_F one[3];
            if (c->cell[j] != cell) continue;
            SKY_(direction)(s, AOMC_SKY_DISC, p, c->u[j], c->v[j], c->rank[j], one);
            x[j] = one[0], y[j] = one[1], z[j] = one[2];
        }
}

/* _other_laws: the photons beside the main law, over those of it; lobes have their turn later. Returns later trials. */
SKY_FN uint64_t SKY_(other_laws)(
    const aomc_sky_source *s, uint64_t m, SKY_(columns) *c, SKY_F *x, SKY_F *y, SKY_F *z) {
    uint64_t j, k, n = 0, n_disc = 0, tries = 0;
    uint32_t disc[SKY_BLOCK];
    for (j = 0; j < m; j++) { /* without branches, which would be guessed wrongly too often */
        int law = s->law[c->cell[j]], is_disc = law == AOMC_SKY_DISC;
        disc[n_disc] = c->chosen[n] = (uint32_t)j;
        n_disc += (uint64_t)is_disc;
        n += (law != s->law_of_all) & !is_disc;
    }
    while (n_disc > 0) { /* the disc of the first photon that is left */
        uint32_t own[SKY_BLOCK];
        SKY_F p[6], u[SKY_BLOCK], v[SKY_BLOCK], out[3][SKY_BLOCK];
        int32_t cell = c->cell[disc[0]];
        uint64_t n_own = 0, left = 0;
        SKY_(parameters)(c, disc[0], p);
        for (k = 0; k < n_disc; k++) {
            int is_own = c->cell[disc[k]] == cell;
            own[n_own] = disc[left] = disc[k];
            n_own += (uint64_t)is_own;
            left += (uint64_t)!is_own;
        }
        for (k = 0; k < n_own; k++) u[k] = c->u[own[k]], v[k] = c->v[own[k]];
        SKY_(discs)(n_own, p, u, v, out[0], out[1], out[2]);
        for (k = 0; k < n_own; k++) x[own[k]] = out[0][k], y[own[k]] = out[1][k], z[own[k]] = out[2][k];
        n_disc = left;
    }
    for (k = 0; k < n; k++) {
        SKY_F p[6], out[3];
        int law;
        j = c->chosen[k], law = s->law[c->cell[j]];
        if (law > AOMC_SKY_DISC_AT_HORIZON) continue;
        SKY_(parameters)(c, j, p);
        tries += SKY_(direction)(s, law, p, c->u[j], c->v[j], c->rank[j], out);
        x[j] = out[0], y[j] = out[1], z[j] = out[2];
    }
    return tries;
}

/* ---- skies/perez/kernels/reject.py ---- */

/* Columns of the photons that are looked at together. */
typedef struct SKY_(tries) {
    SKY_F p[8 * SKY_COLUMN], u[SKY_CHUNK], v[SKY_CHUNK];
    SKY_F x[SKY_CHUNK], y[SKY_CHUNK], z[SKY_CHUNK], scale[SKY_CHUNK];
    uint64_t word[SKY_CHUNK], rank[SKY_CHUNK], place[SKY_CHUNK];
    uint32_t tilt[SKY_CHUNK];
    double bound[SKY_CHUNK], value[SKY_CHUNK];
    aomc_sky_light light;
} SKY_LINES SKY_(tries);

/* _measure_chosen and _gather_cells */
SKY_FN void SKY_(collect)(const aomc_sky_source *s, uint64_t n, const uint32_t *chosen, const SKY_(columns) *c,
    const uint64_t *word, const SKY_F *x, const SKY_F *y, const SKY_F *z, SKY_(tries) *t) {
    uint64_t k;
    for (k = 0; k < n; k++) {
        uint32_t j = chosen[k];
        t->x[k] = x[j], t->y[k] = y[j], t->z[k] = z[j], t->scale[k] = c->jacobian[j];
        t->word[k] = word[j];
        t->bound[k] = s->perez_bound[c->cell[j]];
    }
}

/* Parameters of chosen photons again, and their directions by a later trial. */
SKY_FN void SKY_(again)(const aomc_sky_source *s, uint64_t n, uint32_t trial, const uint32_t *chosen,
    const SKY_(columns) *c, SKY_(tries) *t) {
    uint64_t k, a[SKY_CHUNK], b[SKY_CHUNK];
    for (k = 0; k < n; k++) {
        uint32_t j = chosen[k];
        t->place[k] = s->place[c->cell[j]];
        t->rank[k] = c->rank[j];
        t->tilt[k] = c->cell_word[j];
        t->bound[k] = s->perez_bound[c->cell[j]];
    }
    SKY_(parameters_of_block)(n, s->words, t->place, t->p);
    aomc_sky_pairs(s->placement_key, n, t->rank, s->band, trial, a, b);
    for (k = 0; k < n; k++) {
        t->word[k] = aomc_sky_split_off(a + k, b + k);
        t->u[k] = SKY_(unit)(a[k]);
        t->v[k] = SKY_(unit)(b[k]);
    }
    for (k = 0; k < n; k++) t->scale[k] = SKY_(tilted)(t->u + k, t->v + k, t->tilt[k]);
    SKY_(cells)(s->azimuth_kernel == AOMC_SKY_IN_MU ? AOMC_SKY_ANY_WIDTH
                : s->law                 ? AOMC_SKY_ANY_WIDTH
                                         : s->azimuth_kernel,
        n, t->p, t->u, t->v, t->x, t->y, t->z);
}

/* _luminance and _keep_rejected: those that are refused go to the front of all chosen ones; returns how many there
 * are */
SKY_FN uint64_t SKY_(refuse)(const aomc_sky_source *s, uint64_t n, const uint32_t *part, uint64_t left,
    uint32_t *chosen, SKY_(tries) *t, double *inside) {
    uint64_t k;
    for (k = 0; k < n; k++) {
        t->light.chord[k] = aomc_sky_chord((double)t->x[k], (double)t->y[k], (double)t->z[k], s->sky);
        t->light.mu[k] = -(double)t->z[k];
    }
    aomc_sky_luminances(n, s->sky, &t->light, t->value);
    if (inside)
        for (k = 0; k < n; k++) inside[3 * part[k]] = t->value[k];
    for (k = 0; k < n; k++) {
        t->bound[k] = aomc_sky_uniform(t->word[k]) * t->bound[k];
        t->value[k] = t->value[k] * (double)t->scale[k];
    }
    for (k = 0; k < n; k++) {
        chosen[left] = part[k];
        left += t->bound[k] >= t->value[k];
    }
    return left;
}

/* reject: returns how many trials it took */
SKY_FN uint64_t SKY_(reject)(
    const aomc_sky_source *s, uint64_t m, SKY_(columns) *c, SKY_F *x, SKY_F *y, SKY_F *z, double *inside) {
    SKY_(tries) t;
    uint64_t word[SKY_BLOCK], j, k, lo, n = 0, left = 0, tries = 0;
    uint32_t trial = 1, part[SKY_CHUNK];
    aomc_sky_decisions(s, m, c->rank, 0, word);
    for (j = 0; j < m; j++) {
        c->chosen[n] = (uint32_t)j;
        n += !aomc_sky_is_at_once(word[j], c->cell_word[j]);
    }
    for (lo = 0; lo < n; lo += SKY_CHUNK) {
        k = n - lo < SKY_CHUNK ? n - lo : SKY_CHUNK;
        memcpy(part, c->chosen + lo, k * sizeof *part);
        SKY_(collect)(s, k, part, c, word, x, y, z, &t);
        left = SKY_(refuse)(s, k, part, left, c->chosen, &t, inside);
    }
    for (; left > 6 && trial < SKY_LAST_TRIAL; trial++) {
        tries += n = left;
        for (lo = 0, left = 0; lo < n; lo += SKY_CHUNK) {
            k = n - lo < SKY_CHUNK ? n - lo : SKY_CHUNK;
            memcpy(part, c->chosen + lo, k * sizeof *part);
            SKY_(again)(s, k, trial, part, c, &t);
            for (j = 0; j < k; j++) x[part[j]] = t.x[j], y[part[j]] = t.y[j], z[part[j]] = t.z[j];
            left = SKY_(refuse)(s, k, part, left, c->chosen, &t, inside);
        }
    }
    for (k = 0; k < left; k++) { /* the few that would not fill a vector */
        SKY_F p[6], out[3] = {x[c->chosen[k]], y[c->chosen[k]], z[c->chosen[k]]};
        j = c->chosen[k];
        SKY_(parameters)(c, j, p);
        tries += SKY_(further)(s, trial, p, c->cell[j], c->rank[j], out);
        x[j] = out[0], y[j] = out[1], z[j] = out[2];
        if (inside) inside[3 * j] = aomc_sky_luminance((double)x[j], (double)y[j], (double)z[j], s->sky);
    }
    return tries;
}

/* ---- skies/lobes/kernels: the photons of lobes in a block, those of each lobe side by side ---- */

SKY_FN uint64_t SKY_(lobes)(
    const aomc_sky_source *s, uint64_t m, SKY_(columns) *c, SKY_F *x, SKY_F *y, SKY_F *z, double *inside) {
    uint64_t j, k, n = 0, tries = 0;
    for (j = 0; j < m; j++) {
        c->chosen[n] = (uint32_t)j;
        n += s->lobe[c->cell[j]] >= 0;
    }
    while (n > 0) { /* the lobe of the first photon that is left */
        int32_t lobe = s->lobe[c->cell[c->chosen[0]]];
        uint32_t own[SKY_BLOCK], trial;
        uint64_t p = 0, left = 0, lo, one;
        for (k = 0; k < n; k++) {
            j = c->chosen[k];
            if (s->lobe[c->cell[j]] == lobe) own[p++] = (uint32_t)j;
            else c->chosen[left++] = (uint32_t)j;
        }
        n = left;
        for (trial = 0; p > 0 && trial < SKY_LAST_TRIAL; trial++, tries += p = left) {
            for (lo = 0, left = 0; lo < p; lo += one) {
                aomc_sky_lobe_columns t;
                one = p - lo < SKY_CHUNK ? p - lo : SKY_CHUNK;
                for (k = 0; k < one; k++) t.rank[k] = c->rank[own[lo + k]];
                aomc_sky_lobe_tries(s, lobe, trial, one, &t);
                for (k = 0; k < one; k++) {
                    j = own[lo + k];
                    x[j] = (SKY_F)t.x[k], y[j] = (SKY_F)t.y[k], z[j] = (SKY_F)t.up[k];
                    if (inside) inside[3 * j] = t.x[k], inside[3 * j + 1] = t.y[k], inside[3 * j + 2] = t.up[k];
                    own[left] = (uint32_t)j;
                    left += !(t.excess[k] < 0.0);
                }
            }
        }
    }
    return tries;
}

/* ---- emission/kernels/emit.py again ---- */

/* `_weigh` of emission/photon_source.py: the weights of the photons of cells, whose directions have these z */
SKY_APART void SKY_(weigh)(const aomc_sky_source *s, uint64_t m, const int32_t *SKY_ALONE cell,
    const SKY_F *SKY_ALONE z, SKY_F *SKY_ALONE weight) {
    const SKY_F *of_cell = (const SKY_F *)s->weights;
    uint64_t j;
    for (j = 0; j < m; j++) weight[j] = of_cell ? of_cell[(uint32_t)cell[j]] : (SKY_F)1;
    for (j = 0; s->weight_has_mu && j < m; j++)
        if (aomc_sky_is_in_mu(s, cell[j])) weight[j] *= -z[j];
}

/* emit for one block; returns how many trials it took beside the first ones */
SKY_FN uint64_t SKY_(block)(const aomc_sky_source *s, uint64_t start, uint64_t m, SKY_F *x, SKY_F *y, SKY_F *z,
    double *inside, int32_t *patch, SKY_F *weight) {
    SKY_(columns) c;
    uint64_t j, tries = 0;
    SKY_(gather)(s, start, m, &c);
    if (patch) memcpy(patch, c.cell, m * sizeof *patch);
    SKY_(places)(s, m, &c);
    for (j = 0; s->perez_word && j < m; j++) c.cell_word[j] = s->perez_word[c.cell[j]]; /* gather_cell_words */
    if (s->perez_word)
        for (j = 0; j < m; j++) c.jacobian[j] = SKY_(tilted)(c.u + j, c.v + j, c.cell_word[j]);
    SKY_(cells)(s->azimuth_kernel, m, c.p, c.u, c.v, x, y, z);
    if (s->disc_cell >= 0) SKY_(one_disc)(s, m, &c, x, y, z);
    else if (s->law) tries += SKY_(other_laws)(s, m, &c, x, y, z);
    if (s->perez_word) tries += SKY_(reject)(s, m, &c, x, y, z, inside);
    if (s->lobe) tries += SKY_(lobes)(s, m, &c, x, y, z, inside);
    if (weight) SKY_(weigh)(s, m, c.cell, z, weight);
    return tries;
}

/* `_run` for one width: at most SKY_PIECE photons of one cell, whose words follow each other in steps */
SKY_FORMULA void SKY_(run)(int kernel, uint64_t m, const SKY_F *p, uint64_t u, uint64_t v, uint64_t step_u,
    uint64_t step_v, SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y, SKY_F *SKY_ALONE z) {
    SKY_F h0 = p[0], h1 = p[1], h2 = p[2], h3 = p[3], t0 = p[4], t1 = p[5];
    SKY_LINES SKY_F radius[SKY_PIECE], mu[SKY_PIECE], sine[SKY_PIECE], cosine[SKY_PIECE];
    uint64_t k;
    for (k = 0; k < m; k++) {
        SKY_F place = SKY_(unit)(u);
        SKY_(turned)(kernel, t0, t1, h3, SKY_(unit)(v), sine + k, cosine + k);
        radius[k] = h0 + h1 * place;
        mu[k] = h2 + h1 * ((SKY_F)1 - place);
        u += step_u;
        v += step_v;
    }
    SKY_(roots)(m, radius);
    SKY_(roots)(m, mu);
    for (k = 0; k < m; k++) {
        x[k] = -(radius[k] * cosine[k]);
        y[k] = -(radius[k] * sine[k]);
        z[k] = -mu[k];
    }
}

/* photons of a disc, whose words follow each other in steps */
SKY_FN void SKY_(run_of_disc)(uint64_t m, const SKY_F *p, uint64_t u, uint64_t v, uint64_t step_u, uint64_t step_v,
    SKY_F *x, SKY_F *y, SKY_F *z) {
    SKY_LINES SKY_F of_u[SKY_PIECE], of_v[SKY_PIECE];
    uint64_t k;
    for (k = 0; k < m; k++) {
        of_u[k] = SKY_(unit)(u);
        of_v[k] = SKY_(unit)(v);
        u += step_u;
        v += step_v;
    }
    SKY_(discs)(m, p, of_u, of_v, x, y, z);
}

/* emit_runs: photons in patch order, cell by cell, in the common case */
SKY_FN void SKY_(runs)(const aomc_sky_source *s, uint64_t start, uint64_t n, SKY_F *x, SKY_F *y, SKY_F *z) {
    uint64_t j = 0, slot = aomc_sky_slot(s, start), step_u = s->steps[0], step_v = s->steps[1];
    while (j < n) {
        uint64_t end = aomc_sky_before(s, slot + 1) - start, ring_offset, lo, m;
        SKY_F p[6];
        int32_t cell = s->cell_of_slot ? s->cell_of_slot[slot] : (int32_t)slot;
        ring_offset = SKY_(cell)(s, cell, p);
        end = end < n ? end : n;
        for (lo = j; lo < end; lo += m) {
            uint64_t u = s->shifts[0] + (start + lo) * step_u, v = s->shifts[1] + (start + lo) * step_v + ring_offset;
            /* whole vectors: the next run writes what is behind the end of this one again */
            m = end - lo < SKY_PIECE ? (end - lo + 15) & ~UINT64_C(15) : SKY_PIECE;
            m = m < n - lo ? m : n - lo;
            if (cell == s->disc_cell)
                SKY_(run_of_disc)(m, p, u, v, step_u, step_v, x + lo, y + lo, z + lo);
            else if (s->azimuth_kernel == AOMC_SKY_NARROW)
                SKY_(run)(AOMC_SKY_NARROW, m, p, u, v, step_u, step_v, x + lo, y + lo, z + lo);
            else SKY_(run)(AOMC_SKY_QUARTER, m, p, u, v, step_u, step_v, x + lo, y + lo, z + lo);
        }
        j = end;
        slot++;
    }
}

/* cells and weights of photons in patch order, of which none is launched by solid angle; either may be NULL. A run is
 * written in whole groups, of which the next run writes the rest again. */
SKY_APART void SKY_(cells_of_runs)(
    const aomc_sky_source *s, uint64_t start, uint64_t n, int32_t *patch, SKY_F *weight) {
    uint64_t j = 0, k, lo, m, slot = aomc_sky_slot(s, start), end;
    for (; j < n; j = end, slot++) {
        int32_t cell = s->cell_of_slot ? s->cell_of_slot[slot] : (int32_t)slot;
        SKY_F own = s->weights ? ((const SKY_F *)s->weights)[cell] : (SKY_F)1;
        end = aomc_sky_before(s, slot + 1) - start;
        end = end < n ? end : n;
        for (lo = j; lo < end; lo += SKY_GROUP) {
            m = n - lo;
            if (m >= SKY_GROUP) {
                for (k = 0; patch && k < SKY_GROUP; k++) patch[lo + k] = cell;
                for (k = 0; weight && k < SKY_GROUP; k++) weight[lo + k] = own;
                continue;
            }
            for (k = 0; patch && k < m; k++) patch[lo + k] = cell;
            for (k = 0; weight && k < m; k++) weight[lo + k] = own;
        }
    }
}

/* Photons from `start` on; their number, or AOMC_SKY_TRIALS. `inside`, `patch` and `weight` may be NULL. */
SKY_FN int64_t SKY_(range)(const aomc_sky_source *s, uint64_t start, uint64_t n, SKY_F *ux, SKY_F *uy, SKY_F *uz,
    double *inside, int32_t *patch, SKY_F *weight) {
    uint64_t lo, m, tries = 0;
    if (!s->is_shuffled && s->is_common && !s->by_philox && (uint64_t)s->n >= 8 * (uint64_t)s->n_slot) {
        SKY_(runs)(s, start, n, ux, uy, uz);
        if (patch || weight) SKY_(cells_of_runs)(s, start, n, patch, weight);
        return (int64_t)n;
    }
    for (lo = 0; lo < n; lo += m) {
        m = n - lo < SKY_BLOCK ? n - lo : SKY_BLOCK;
        tries += SKY_(block)(s, start + lo, m, ux + lo, uy + lo, uz + lo, inside ? inside + 3 * lo : NULL,
            patch ? patch + lo : NULL, weight ? weight + lo : NULL);
        if (tries > 10000000 + 1000 * lo) return AOMC_SKY_TRIALS;
    }
    return (int64_t)n;
}

/* ---- positions of emission/kernels/emit.py ---- */

/* sincos_turned_any of a full turn from x = -2 to 2: a large number rounds in every processor, and x is never -0 */
SKY_FORMULA void SKY_(full_turn)(SKY_F v, SKY_F *sine, SKY_F *cosine) {
    const SKY_F zero = 0, one = 1, large = (SKY_F)(AOMC_SKY_PRECISION == 4 ? 12582912.0 : 6755399441055744.0);
    SKY_F x = (SKY_F)2 * (v + v - one), turns = (x + large) - large, s0, c0, s, c;
    int32_t quarter = (int32_t)turns;
    SKY_(sincos_quarter)(x - turns, &s0, &c0);
    s = quarter & 1 ? c0 : s0;
    c = quarter & 1 ? s0 : c0;
    s = quarter & 2 ? -s : s;
    c = (quarter + 1) & 2 ? -c : c;
    *sine = zero * c + one * s;
    *cosine = one * c - zero * s;
}

/* in_circle and in_rectangle for at most SKY_PIECE photons: from two numbers to a position, in the same arrays */
SKY_FORMULA void SKY_(on_circle)(uint64_t m, SKY_F radius, SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y) {
    SKY_LINES SKY_F sine[SKY_PIECE], cosine[SKY_PIECE];
    uint64_t j;
    for (j = 0; j < m; j++) SKY_(full_turn)(y[j], sine + j, cosine + j);
    SKY_(roots)(m, x);
    for (j = 0; j < m; j++) {
        SKY_F r = radius * x[j];
        x[j] = r * cosine[j];
        y[j] = r * sine[j];
    }
}

SKY_FORMULA void SKY_(on_rectangle)(
    uint64_t m, SKY_F size_x, SKY_F size_y, SKY_F *SKY_ALONE x, SKY_F *SKY_ALONE y) {
    const SKY_F half = (SKY_F)0.5;
    uint64_t j;
    for (j = 0; j < m; j++) x[j] = size_x * (x[j] - half);
    for (j = 0; j < m; j++) y[j] = size_y * (y[j] - half);
}

/* positions: either of x and y may be NULL */
SKY_FN void SKY_(position_range)(const aomc_sky_source *s, uint64_t start, uint64_t n, SKY_F *x, SKY_F *y) {
    SKY_F size_x = (SKY_F)s->footprint_m[0], size_y = (SKY_F)s->footprint_m[1];
    SKY_F radius = (SKY_F)(s->footprint_m[0] / 2.0);
    uint64_t lo, j, m;
    for (lo = 0; lo < n; lo += m) {
        SKY_LINES SKY_F u[SKY_PIECE], v[SKY_PIECE];
        m = n - lo < SKY_PIECE ? n - lo : SKY_PIECE;
        if (s->footprint == AOMC_SKY_POINT) {
            for (j = 0; j < m; j++) u[j] = v[j] = (SKY_F)0;
        } else {
            SKY_LINES uint64_t index[SKY_PIECE], a[SKY_PIECE], b[SKY_PIECE];
            for (j = 0; j < m; j++) index[j] = start + lo + j;
            aomc_sky_pairs(s->position_key, m, index, s->band, 0, a, b);
            for (j = 0; j < m; j++) u[j] = SKY_(unit)(a[j]);
            for (j = 0; j < m; j++) v[j] = SKY_(unit)(b[j]);
            if (s->footprint == AOMC_SKY_RECTANGLE) SKY_(on_rectangle)(m, size_x, size_y, u, v);
            else if (m == SKY_PIECE) SKY_(on_circle)(SKY_PIECE, radius, u, v);
            else SKY_(on_circle)(m, radius, u, v);
        }
        if (x) memcpy(x + lo, u, m * sizeof *x);
        if (y) memcpy(y + lo, v, m * sizeof *y);
    }
}

/* ---- emission/kernels/numbers.py ---- */

/* numbers_of_photons */
SKY_FN void SKY_(number_range)(const aomc_sky_source *s, uint64_t start, uint64_t n, SKY_F *n1, SKY_F *n2, SKY_F *n3) {
    uint64_t lo, j, m;
    for (lo = 0; lo < n; lo += m) {
        uint64_t rank[SKY_BLOCK], a[SKY_BLOCK], b[SKY_BLOCK];
        uint32_t point[SKY_BLOCK];
        int c;
        m = n - lo < SKY_BLOCK ? n - lo : SKY_BLOCK;
        aomc_sky_ranks(s, start + lo, m, rank);
        for (j = 0; s->by_net && j < m; j++) point[j] = aomc_sky_point(rank[j], s->number_steps[0]);
        for (c = 0; c < 3; c++) {
            SKY_F *out = c == 0 ? n1 : c == 1 ? n2 : n3;
            uint64_t shift = s->number_shifts[c], step = s->number_steps[c], *word = c == 1 ? b : a;
            if (s->by_philox && (c == 0 ? n1 || n2 : c == 2 && n3)) /* one pair has the first two numbers */
                aomc_sky_pairs(s->position_key, m, rank, s->band, c == 2 ? 2 : 1, a, b);
            if (!out) continue;
            if (s->by_philox)
                for (j = 0; j < m; j++) out[lo + j] = SKY_(unit)(word[j]);
            else if (s->by_net && c == 0)
                for (j = 0; j < m; j++) out[lo + j] = SKY_(unit)(aomc_sky_net_word(point[j], shift));
            else if (s->by_net && c == 1)
                for (j = 0; j < m; j++) out[lo + j] = SKY_(unit)(aomc_sky_net_word(aomc_sky_second(point[j]), shift));
            else if (s->by_net)
                for (j = 0; j < m; j++) out[lo + j] = SKY_(unit)(aomc_sky_net_word(aomc_sky_third(point[j]), shift));
            else
                for (j = 0; j < m; j++) out[lo + j] = SKY_(unit)(shift + rank[j] * step);
        }
    }
}

SKY_FN uint64_t SKY_(word_of_position)(SKY_F x, SKY_F y) {
    uint64_t a = 0, b = 0;
    memcpy(&a, &x, sizeof x);
    memcpy(&b, &y, sizeof y);
    return a ^ (b << 32 | b >> 32);
}

/* Whether a photon is the witness w, alone and in a block: index, patch, directions, numbers, what is inside, and a word
 * of its position, 0 of a point and in older files. */
SKY_FN int SKY_(agrees)(const aomc_sky_source *s, const uint64_t *w) {
    SKY_F one[6], all[6];
    double inside[3];
    uint64_t i = w[0], rank;
    int32_t patch, c, bad = 0;
    if (i >= (uint64_t)s->n) return 0;
    inside[0] = inside[1] = inside[2] = NAN;
    patch = SKY_(photon)(s, i, one, inside);
    rank = aomc_sky_rank(s, i);
    for (c = 0; c < 3; c++) one[3 + c] = SKY_(unit)(aomc_sky_number_word(s, rank, c));
    for (c = 0; c < 6; c++) {
        uint64_t word = 0;
        memcpy(&word, one + c, sizeof one[c]);
        bad |= word != w[2 + c];
    }
    for (c = 0; c < 3; c++) bad |= w[8 + c] != SKY_UNKNOWN && aomc_sky_bits(inside[c]) != w[8 + c];
    SKY_(position_range)(s, i, 1, all, all + 1);
    bad |= patch != (int32_t)w[1] || (w[11] != 0 && SKY_(word_of_position)(all[0], all[1]) != w[11]);
#ifndef SKY_ON_DEVICE
    {
        SKY_F block[6][SKY_BLOCK];
        double within[3 * SKY_BLOCK];
        uint64_t n = (uint64_t)s->n, m = n < SKY_BLOCK ? n : SKY_BLOCK, j = i < n - m ? i % 64 : i - (n - m);
        for (c = 0; c < (int32_t)(3 * m); c++) within[c] = NAN;
        if (SKY_(range)(s, i - j, m, block[0], block[1], block[2], within, NULL, NULL) < 0) return 0;
        SKY_(number_range)(s, i - j, m, block[3], block[4], block[5]);
        for (c = 0; c < 6; c++) all[c] = block[c][j];
        bad |= memcmp(one, all, sizeof one) != 0;
        for (c = 0; c < 3; c++) /* what a block knows of it: luminances are not worked out for all photons */
            bad |= w[8 + c] != SKY_UNKNOWN && within[3 * j + (uint64_t)c] == within[3 * j + (uint64_t)c] &&
                   aomc_sky_bits(within[3 * j + (uint64_t)c]) != w[8 + c];
    }
#else
    (void)all;
#endif
    return !bad;
}

#endif /* AOMC_SKY_PRECISION */
