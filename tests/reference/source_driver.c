/* Functions over aomc_sky.h for the tests; compiled as C and as C++, with many flags. */
#include "aomc_sky.h"

#ifdef __cplusplus
extern "C" {
#endif

static aomc_sky_file file;
static aomc_sky_source source, sources[16];
static int32_t n_sources;

int driver_view(const void *bytes, uint64_t size)
{
    return aomc_sky_view(bytes, size, &file);
}

int driver_load(const char *path)
{
    aomc_sky_file one;
    int code = aomc_sky_load(path, &one);
    aomc_sky_unload(&one);
    return code;
}

int driver_band(int32_t band)
{
    return aomc_sky_band(&file, band, &source);
}

int driver_weighted_band(int32_t band)
{
    return aomc_sky_weighted_band(&file, band, &source);
}

int driver_replicate(int32_t band, int32_t replicate, int is_weighted)
{
    if (is_weighted) return aomc_sky_weighted_replicate(&file, band, replicate, &source);
    return aomc_sky_replicate(&file, band, replicate, &source);
}

/* Weight of a photon with this direction and patch. */
static double weight_of(int is_double, float uz, double uz_double, int32_t patch)
{
    aomc_sky_photon p = {0, 0, 0, 0};
    aomc_sky_photon_double q = {0, 0, 0, 0};
    p.uz = uz, q.uz = uz_double, p.patch = q.patch = patch;
    return is_double ? aomc_sky_weight_double(&source, q) : aomc_sky_weight(&source, p);
}

void driver_weight(int is_double, int64_t n, const void *uz, const int32_t *patch, double *weight)
{
    int64_t j;
    for (j = 0; j < n; j++) {
        if (is_double) weight[j] = weight_of(1, 0, ((const double *)uz)[j], patch[j]);
        else weight[j] = weight_of(0, ((const float *)uz)[j], 0, patch[j]);
    }
}

int32_t driver_component(int32_t patch)
{
    return aomc_sky_component(&source, patch);
}

double driver_photon_light(void)
{
    return source.photon_light;
}

int64_t driver_fill_weighted(
    int is_double, int64_t start, int64_t n, void *x, void *y, void *z, int32_t *patch, void *weight)
{
    if (is_double)
        return aomc_sky_fill_weighted_double(
            &source, start, n, (double *)x, (double *)y, (double *)z, patch, (double *)weight);
    return aomc_sky_fill_weighted(&source, start, n, (float *)x, (float *)y, (float *)z, patch, (float *)weight);
}

int64_t driver_positions(int is_double, int64_t start, int64_t n, void *x, void *y)
{
    if (is_double) return aomc_sky_positions_double(&source, start, n, (double *)x, (double *)y);
    return aomc_sky_positions(&source, start, n, (float *)x, (float *)y);
}

/* Positions one by one, x and y side by side. */
void driver_position(int is_double, const int64_t *index, int64_t n, void *xy)
{
    int64_t j;
    for (j = 0; j < n; j++) {
        if (is_double) aomc_sky_position_double(&source, index[j], (double *)xy + 2 * j);
        else aomc_sky_position(&source, index[j], (float *)xy + 2 * j);
    }
}

/* The bands of the file for a stream, in addition to others where `is_more`. */
int driver_take_bands(int is_more)
{
    int32_t band, replicate;
    int code = 0;
    if (!is_more) n_sources = 0;
    for (replicate = 0; replicate < file.n_replicates; replicate++)
        for (band = 0; code == 0 && band < file.n_bands; band++)
            code = n_sources < 16 ? aomc_sky_weighted_replicate(&file, band, replicate, sources + n_sources++) : 1;
    return code;
}

/* Particles of a stream from `from` to `to`, at most `count`: six columns of floats, four of integers. Returns their
 * number, or a code. */
int64_t driver_stream(int64_t from, int64_t to, int64_t count, double *f, int64_t *whole, int64_t *total)
{
    aomc_sky_stream stream;
    aomc_sky_particle p;
    int64_t j;
    int code = aomc_sky_particles(&stream, sources, n_sources, from, to);
    *total = stream.n;
    for (j = 0; code == 0 && j < count; j++) {
        if (stream.at != (from < stream.n ? from : stream.n) + j) return -1000;
        code = aomc_sky_next(&stream, &p);
        if (code == 0) return j;
        if (code < 0) return code;
        code = 0;
        f[j] = p.ux, f[count + j] = p.uy, f[2 * count + j] = p.uz;
        f[3 * count + j] = p.weight, f[4 * count + j] = p.x, f[5 * count + j] = p.y;
        whole[j] = p.index, whole[count + j] = p.band, whole[2 * count + j] = p.patch;
        whole[3 * count + j] = p.component;
    }
    return code < 0 ? code : j;
}

int64_t driver_n(void)
{
    return source.n;
}

int driver_witness(void)
{
    return aomc_sky_witness(&source);
}

uint64_t driver_checksum(const void *bytes, uint64_t size)
{
    return aomc_sky_checksum(bytes, size);
}

const char *driver_message(int64_t code)
{
    return aomc_sky_message(code);
}

int64_t driver_fill(int is_double, int64_t start, int64_t n, void *x, void *y, void *z)
{
    if (is_double) return aomc_sky_fill_double(&source, start, n, (double *)x, (double *)y, (double *)z);
    return aomc_sky_fill(&source, start, n, (float *)x, (float *)y, (float *)z);
}

int64_t driver_numbers(int is_double, int64_t start, int64_t n, void *n1, void *n2, void *n3)
{
    if (is_double) return aomc_sky_numbers_double(&source, start, n, (double *)n1, (double *)n2, (double *)n3);
    return aomc_sky_numbers(&source, start, n, (float *)n1, (float *)n2, (float *)n3);
}

/* Six rows: directions and numbers of photons by their indices. */
void driver_at(int is_double, const int64_t *index, int64_t n, void *rows, int32_t *patch)
{
    int64_t j;
    int c;
    for (j = 0; j < n; j++) {
        if (is_double) {
            double *out = (double *)rows, numbers[3];
            aomc_sky_photon_double p = aomc_sky_at_double(&source, index[j]);
            aomc_sky_numbers_at_double(&source, index[j], numbers);
            out[j] = p.ux, out[n + j] = p.uy, out[2 * n + j] = p.uz, patch[j] = p.patch;
            for (c = 0; c < 3; c++) out[(3 + c) * n + j] = numbers[c];
        } else {
            float *out = (float *)rows, numbers[3];
            aomc_sky_photon p = aomc_sky_at(&source, index[j]);
            aomc_sky_numbers_at(&source, index[j], numbers);
            out[j] = p.ux, out[n + j] = p.uy, out[2 * n + j] = p.uz, patch[j] = p.patch;
            for (c = 0; c < 3; c++) out[(3 + c) * n + j] = numbers[c];
        }
    }
}

#ifdef DRIVER_MAIN
/* the bits of a number */
static inline uint64_t word_of(double x)
{
    uint64_t word;
    memcpy(&word, &x, 8);
    return word;
}

/* Photons of every file named: a sum of bits, or the code. */
int main(int count, char **arguments)
{
    int k;
    for (k = 1; k < count; k++) {
        int32_t band;
        uint64_t sum = 0;
        int code = aomc_sky_load(arguments[k], &file);
        for (band = 0; code == 0 && band < file.n_bands * file.n_replicates; band++) {
            int64_t n = 0, start, j;
            static double x[3][4096];
            static float y[3][4096];
            code = aomc_sky_weighted_replicate(&file, band % file.n_bands, band / file.n_bands, &source);
            for (start = 0; code == 0 && start < source.n && start < 200000; start += n) {
                if (file.precision == 8) n = aomc_sky_fill_double(&source, start, 4096, x[0], x[1], x[2]);
                else n = aomc_sky_fill(&source, start, 4096, y[0], y[1], y[2]);
                if (n <= 0) break;
                for (j = 0; j < 3 * n; j++) {
                    uint64_t word = 0;
                    if (file.precision == 8) memcpy(&word, &x[j / n][j % n], 8);
                    else memcpy(&word, &y[j / n][j % n], 4);
                    sum = (sum ^ word) * UINT64_C(0x9E3779B97F4A7C15);
                    sum ^= sum >> 32;
                }
                for (j = 0; j < n; j++) { /* weight and component go by the patch */
                    static int32_t patch[4096];
                    double weight;
                    if (j == 0 && file.precision == 8)
                        aomc_sky_fill_weighted_double(&source, start, 4096, x[0], x[1], x[2], patch, NULL);
                    else if (j == 0)
                        aomc_sky_fill_weighted(&source, start, 4096, y[0], y[1], y[2], patch, NULL);
                    weight = weight_of(file.precision == 8, y[2][j], x[2][j], patch[j]);
                    weight *= 2 + aomc_sky_component(&source, patch[j]);
                    sum = (sum ^ word_of(weight) ^ (uint64_t)patch[j]) * UINT64_C(0x9E3779B97F4A7C15);
                    sum ^= sum >> 32;
                }
                if (file.precision == 8) aomc_sky_positions_double(&source, start, n, x[0], x[1]);
                else aomc_sky_positions(&source, start, n, y[0], y[1]);
                for (j = 0; j < n; j++) {
                    double place = file.precision == 8 ? x[0][j] - x[1][j] : (double)y[0][j] - (double)y[1][j];
                    sum = (sum ^ word_of(place)) * UINT64_C(0x9E3779B97F4A7C15);
                }
                for (j = 0; j < n && j < 64; j++) {
                    uint64_t word = 0;
                    if (file.precision == 8) { double one = aomc_sky_at_double(&source, start + j).ux; memcpy(&word, &one, 8); }
                    else { float one = aomc_sky_at(&source, start + j).ux; memcpy(&word, &one, 4); }
                    sum = (sum ^ word) * UINT64_C(0x9E3779B97F4A7C15);
                }
            }
            if (n < 0) code = (int)n;
        }
        if (code == 0 && file.n_bands * file.n_replicates <= 16 && driver_take_bands(0) == 0) {
            aomc_sky_stream stream;
            aomc_sky_particle p;
            int64_t part;
            for (part = 0; part < 3; part++) { /* the begin, the middle and the end */
                int made = aomc_sky_particles(&stream, sources, n_sources, 0, INT64_MAX);
                int64_t from = part == 0 || stream.n < 10000 ? 0 : (stream.n - 10000) / 2 * part;
                if (made == 0) made = aomc_sky_particles(&stream, sources, n_sources, from, from + 10000);
                while (made == 0 && (made = aomc_sky_next(&stream, &p)) > 0) {
                    sum = (sum ^ word_of(p.ux) ^ word_of(p.weight)) * UINT64_C(0x9E3779B97F4A7C15);
                    sum ^= (uint64_t)p.index ^ (uint64_t)p.band ^ (uint64_t)p.component << 32;
                    made = 0;
                }
                sum ^= (uint64_t)(uint32_t)made;
            }
        }
        printf("%d %016llx\n", code, (unsigned long long)sum);
        aomc_sky_unload(&file);
    }
    return 0;
}
#endif

#ifdef __cplusplus
}
#endif
