/* The photons of a table as one would write them in C, with the bits of the kernels: emission.py times both.

   gcc -O3 -march=native -ffp-contract=off -fno-math-errno -shared -fPIC -DREAL=float -DLANE=4 hand_written.c

   The table has rows of four REALs: three parameters and the offset of a ring, sine, cosine and half width of a column.
   `place` has the words (8 bytes) at which the two rows of a slot begin. Up to 2^32 photons, 2^16 slots and words. */

#include <math.h>
#include <stdint.h>
#include <string.h>

#define BLOCK 2048
#define MIN(a, b) ((a) < (b) ? (a) : (b))
#define NUMBERS(a) (int)(sizeof(a) / sizeof *(a))

#if LANE == 4
typedef uint32_t Word;
#define ROOT sqrtf
static const REAL SINE[] = {-0.6459640975062463, 1.5707963267948966}, COSINE[] = {-1.2337005501361697, 1};
#else
typedef uint64_t Word;
#define ROOT sqrt
static const REAL SINE[] = {-0.004681754135318688, 0.07969262624616705, -0.6459640975062463, 1.5707963267948966};
static const REAL COSINE[] = {-0.02086348076335296, 0.25366950790104803, -1.2337005501361697, 1};
#endif

typedef struct {
    uint64_t n, shift[2], step[2], guide_shift, key[3];
    const uint32_t *cumulative, *place;
    const uint16_t *guide;
    const REAL *table;
} Band;

static inline REAL unit(uint64_t bits)
{
    if (sizeof(REAL) == 4)
        return (int32_t)(bits >> 40) * 0x1p-24f;
#ifdef __AVX512DQ__
    return (double)(int64_t)(bits >> 11) * 0x1p-53;
#endif
    const uint64_t word[2] = {bits >> 12 | 0x3FF0000000000000u, (bits & 0x800) | 0x3F30000000000000u};
    double high, low; /* 1 and 52 bits, 2^-12 and the last one: AVX2 converts no 64-bit integers */
    memcpy(&high, &word[0], 8);
    memcpy(&low, &word[1], 8);
    return high - (1 + 0x1p-12) + low;
}

static inline uint64_t ring_offset_of(REAL seen)
{
    Word ring_offset;
    memcpy(&ring_offset, &seen, sizeof ring_offset);
    return (uint64_t)ring_offset << (64 - 8 * sizeof ring_offset);
}

typedef REAL Lane __attribute__((vector_size(16)));
typedef Word Order __attribute__((vector_size(16)));

/* Number k of all vectors in vector k. */
static inline void turn_lanes(Lane *a)
{
#if LANE == 4
    const Order low = {0, 4, 1, 5}, high = {2, 6, 3, 7};
    const Lane ac = __builtin_shuffle(a[0], a[2], low), bd = __builtin_shuffle(a[1], a[3], low);
    const Lane ac2 = __builtin_shuffle(a[0], a[2], high), bd2 = __builtin_shuffle(a[1], a[3], high);
    a[0] = __builtin_shuffle(ac, bd, low), a[1] = __builtin_shuffle(ac, bd, high);
    a[2] = __builtin_shuffle(ac2, bd2, low), a[3] = __builtin_shuffle(ac2, bd2, high);
#else
    const Order low = {0, 2}, high = {1, 3};
    const Lane first = a[0];
    a[0] = __builtin_shuffle(first, a[1], low), a[1] = __builtin_shuffle(first, a[1], high);
#endif
}

/* A direction in a cell at most 3 degrees wide. */
static inline void place_photon(REAL h0, REAL h1, REAL h2, REAL half, REAL t0, REAL t1, REAL u, REAL v, REAL *x,
                                REAL *y, REAL *z)
{
    const REAL r = half * (v + v - 1), t = r * r, radius = ROOT(h0 + h1 * u);
    REAL s = SINE[0], c = COSINE[0];
    for (int k = 1; k < NUMBERS(SINE); k++)
        s = s * t + SINE[k];
    for (int k = 1; k < NUMBERS(COSINE); k++)
        c = c * t + COSINE[k];
    s *= r;
    *x = -(radius * (t1 * c - t0 * s));
    *y = -(radius * (t0 * c + t1 * s));
    *z = -ROOT(h2 + h1 * (1 - u));
}

static inline uint32_t mix(uint32_t half, uint32_t key)
{
    uint32_t x = half * 0x7FEB352D + key;
    return (x ^ x >> 15) * 0x846CA68B;
}

static inline uint32_t high_step(uint32_t high, uint32_t low, uint32_t key, uint32_t b)
{
    high += (mix(low, key) >> 16) * b >> 16;
    return MIN(high, high - b);
}

static inline uint32_t permuted(uint32_t i, uint32_t s, uint32_t b, const uint64_t *key)
{
    uint32_t mask = (1u << s) - 1, low = i & mask, high = high_step(i >> s, low, key[0], b);
    low = (low + (mix(high, key[1]) >> (32 - s))) & mask;
    return high_step(high, low, key[2], b) << s | low;
}

static inline uint32_t slot_of(uint32_t rank, const Band *band)
{
    uint32_t s = band->guide[rank >> band->guide_shift];
    if (rank < band->cumulative[s + 2])
        return s + (rank >= band->cumulative[s + 1]); /* nearly always, and without a branch */
    while (rank >= band->cumulative[s + 1])
        s++;
    return s;
}

/* The first or second row of a slot. */
static inline const REAL *row_of(uint32_t slot, int second, const Band *band)
{
    return band->table + (second ? band->place[slot] & 0xFFFF : band->place[slot] >> 16) * (8 / sizeof(REAL));
}

void shuffled(const Band *band, uint64_t start, uint64_t n, REAL *restrict ux, REAL *restrict uy, REAL *restrict uz,
              int32_t *restrict cell)
{
    const Band of = *band;
    uint32_t s = 1, rank[BLOCK];
    REAL p[8][BLOCK + 24];
    while (1ull << 2 * s < of.n)
        s++;
    const uint32_t b = ((of.n - 1) >> s) + 1;
    for (uint64_t lo = 0; lo < n; lo += BLOCK) {
        const uint32_t m = MIN(n - lo, BLOCK);
        for (uint32_t j = 0; j < m; j++)
            rank[j] = permuted(start + lo + j, s, b, of.key);
        for (uint32_t j = 0; j < m; j++) {
            while (rank[j] >= of.n)
                rank[j] = permuted(rank[j], s, b, of.key);
            cell[lo + j] = slot_of(rank[j], &of);
        }
        for (uint32_t j = 0; j < m; j += LANE) { /* from rows to columns, in vectors of 16 bytes */
            for (int k = 0; k < 8; k += LANE) {
                Lane a[LANE];
                for (int i = 0; i < LANE; i++)
                    memcpy(&a[i], row_of(cell[lo + MIN(j + i, m - 1)], k >= 4, &of) + k % 4, 16);
                turn_lanes(a);
                for (int i = 0; i < LANE; i++)
                    memcpy(&p[k + i][j], &a[i], 16);
            }
        }
        for (uint32_t j = 0; j < m; j++)
            place_photon(p[0][j], p[1][j], p[2][j], p[6][j], p[4][j], p[5][j],
                         unit(of.shift[0] + rank[j] * of.step[0]),
                         unit(of.shift[1] + rank[j] * of.step[1] + ring_offset_of(p[3][j])),
                         &ux[lo + j], &uy[lo + j], &uz[lo + j]);
    }
}

void in_order(const Band *band, uint64_t start, uint64_t n, REAL *restrict ux, REAL *restrict uy, REAL *restrict uz,
              int32_t *restrict cell)
{
    uint64_t j = 0;
    for (uint32_t slot = slot_of(start, band); j < n; slot++) {
        const uint64_t end = MIN(n, band->cumulative[slot + 1] - start), whole = MIN(n, j + ((end - j + 15) & ~15ull));
        const REAL *h = row_of(slot, 0, band), *t = row_of(slot, 1, band);
        const REAL h0 = h[0], h1 = h[1], h2 = h[2], t0 = t[0], t1 = t[1], half = t[2];
        uint64_t u = band->shift[0] + (start + j) * band->step[0];
        uint64_t v = band->shift[1] + (start + j) * band->step[1] + ring_offset_of(h[3]);
        for (uint64_t i = j; i < whole; i++, u += band->step[0], v += band->step[1]) {
            place_photon(h0, h1, h2, half, t0, t1, unit(u), unit(v), &ux[i], &uy[i], &uz[i]);
            cell[i] = slot; /* the next run writes what stands beyond the end of this one again */
        }
        j = end;
    }
}
