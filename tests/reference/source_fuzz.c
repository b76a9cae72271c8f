/* Damages a source file again and again and asks aomc_sky.h for its photons: FILE COUNT SEED IS_SEALED.
 *
 * Sanitizers watch. With IS_SEALED 0 every damage must give a code. With 1 the checksum is made right again, so the
 * checks behind it are asked; what they let pass must be safe to use. Prints how often each code came. */
#include "aomc_sky.h"

static uint64_t state;

static uint64_t draw(uint64_t n)
{
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (state >> 24) % n;
}

static const uint64_t extreme[] = {
    0, 1, 2, 0x7F, 0x80, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, UINT64_C(1) << 32, UINT64_C(1) << 62,
    UINT64_C(0x7FFFFFFFFFFFFFFF), UINT64_MAX, UINT64_C(0x7FF0000000000000), UINT64_C(0x7FF8000000000000),
    UINT64_C(0x7E37E43C8800759C), UINT64_C(0xBFF0000000000000), UINT64_C(0x7F8000007F800000), 64, 4096};

/* Where a damage hits: often head, records and directories, where most checks are. */
static uint64_t place(uint64_t size)
{
    uint64_t first = 0;
    switch (draw(4)) {
    case 0: return draw(192);
    case 1: return size > 192 + 960 ? 192 + draw(960) : draw(size);
    default: first = draw(size);
    }
    return first;
}

static void damage(unsigned char *bytes, uint64_t size)
{
    uint64_t k, n = 1 + draw(3), at, word;
    for (k = 0; k < n; k++) {
        at = place(size);
        switch (draw(4)) {
        case 0: bytes[at] ^= (unsigned char)(1u << draw(8)); break;
        case 1: bytes[at] = (unsigned char)draw(256); break;
        default:
            at = at / 8 * 8;
            word = extreme[draw(sizeof extreme / sizeof *extreme)] + draw(3) - 1;
            if (draw(2)) memcpy(bytes + at, &word, 8);
            else memcpy(bytes + at + 4 * draw(2), &word, 4);
        }
    }
}

/* Particles of all bands, from any place. */
static double use_stream(const aomc_sky_file *file)
{
    static aomc_sky_source sources[8];
    static aomc_sky_stream stream;
    aomc_sky_particle p;
    double sum = 0;
    int64_t from;
    int32_t band;
    if (file->n_bands > 8) return 0;
    for (band = 0; band < file->n_bands; band++)
        if (aomc_sky_weighted_replicate(file, band, file->n_replicates - 1, sources + band) != 0) return 0;
    if (aomc_sky_particles(&stream, sources, file->n_bands, 0, INT64_MAX) != 0 || stream.n == 0) return 0;
    from = (int64_t)draw((uint64_t)stream.n);
    if (aomc_sky_particles(&stream, sources, file->n_bands, from, stream.n - from > 700 ? from + 700 : stream.n)) return 0;
    while (aomc_sky_next(&stream, &p) > 0) sum += p.ux + p.weight + p.x + p.y + (double)(p.component + p.patch + p.index);
    return sum;
}

static void use(const aomc_sky_file *file)
{
    static float x[3][700];
    static double y[3][700], weight_double[700], sum;
    static float weight[700];
    static int32_t patch[700];
    int32_t band;
    for (band = 0; band < file->n_bands; band++) {
        aomc_sky_source source;
        int64_t start, k, n;
        int32_t replicate = (int32_t)draw((uint64_t)file->n_replicates);
        if (aomc_sky_weighted_replicate(file, band, replicate, &source) != 0 || source.n == 0) continue;
        start = (int64_t)draw((uint64_t)source.n);
        if (file->precision == 4) {
            aomc_sky_fill(&source, start, 700, x[0], x[1], x[2]);
            n = aomc_sky_fill_weighted(&source, start, 700, x[0], x[1], x[2], patch, weight);
            aomc_sky_numbers(&source, start, 700, x[0], NULL, x[2]);
            aomc_sky_positions(&source, start, 700, x[0], x[1]);
        } else {
            aomc_sky_fill_double(&source, start, 700, y[0], y[1], y[2]);
            n = aomc_sky_fill_weighted_double(&source, start, 700, y[0], y[1], y[2], patch, weight_double);
            aomc_sky_numbers_double(&source, start, 700, y[0], NULL, y[2]);
            aomc_sky_positions_double(&source, start, 700, y[0], y[1]);
        }
        for (k = 0; k < n; k++) sum += aomc_sky_component(&source, patch[k]);
        for (k = 0; k < 20; k++) {
            int64_t i = (int64_t)draw((uint64_t)source.n);
            sum += file->precision == 4 ? aomc_sky_weight(&source, aomc_sky_at(&source, i))
                                        : aomc_sky_weight_double(&source, aomc_sky_at_double(&source, i));
        }
    }
    sum += use_stream(file);
}

int main(int count, char **arguments)
{
    FILE *stream = count == 5 ? fopen(arguments[1], "rb") : NULL;
    long size, k, n, codes[20] = {0}, same = 0;
    unsigned char *whole;
    int is_sealed;
    if (!stream) return 2;
    fseek(stream, 0, SEEK_END);
    size = ftell(stream);
    rewind(stream);
    whole = (unsigned char *)malloc((size_t)size);
    if (!whole || fread(whole, 1, (size_t)size, stream) != (size_t)size) return 2;
    fclose(stream);
    n = atol(arguments[2]), state = strtoull(arguments[3], NULL, 10), is_sealed = atoi(arguments[4]);
    for (k = 0; k < n; k++) {
        uint64_t left = draw(8) == 0 ? draw((uint64_t)size + 1) / 8 * 8 : (uint64_t)size, seal;
        unsigned char *bytes = (unsigned char *)malloc(left ? left : 1); /* as long as the file, for the sanitizer */
        aomc_sky_file file;
        int code;
        if (!bytes) return 2;
        memcpy(bytes, whole, left);
        if (left >= 192) damage(bytes, left);
        if (is_sealed && left >= 192) {
            if (draw(2)) memcpy(bytes + 32, &left, 8);
            seal = aomc_sky_checksum(bytes, left);
            memcpy(bytes + 40, &seal, 8);
        }
        code = aomc_sky_view(bytes, left, &file);
        if (code < -19 || code > 0) return 3;
        codes[-code]++;
        if (code == 0) {
            same += left == (uint64_t)size && memcmp(bytes, whole, left) == 0;
            use(&file);
        }
        free(bytes);
    }
    for (k = 0; k < 20; k++)
        if (codes[k]) printf("%ld: %ld\n", -k, codes[k]);
    printf("unchanged: %ld\n", same);
    free(whole);
    return 0;
}
