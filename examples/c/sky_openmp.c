/* The same on all cores: any thread asks for any photons, for they depend on their index alone.
 *
 *     sky_openmp day.sky
 */
#include "example.h"

int main(int argc, char **argv)
{
    aomc_sky_file file;
    aomc_sky_source source;
    if (argc != 2) return fprintf(stderr, "usage: %s FILE\n", argv[0]), 2;
    need(aomc_sky_load(argv[1], &file));
    for (int32_t band = 0; band < file.n_bands; band++) {
        double cosine = 0;
        uint64_t bits = 0;
        need(aomc_sky_band(&file, band, &source));
#pragma omp parallel for reduction(+ : cosine) reduction(^ : bits) schedule(dynamic)
        for (int64_t start = 0; start < source.n; start += 4096) {
            float ux[4096], uy[4096], uz[4096];
            const int64_t n = need(aomc_sky_fill(&source, start, 4096, ux, uy, uz));
            for (int64_t i = 0; i < n; i++) { /* here your photon goes its way */
                cosine -= uz[i];
                bits ^= bits_of(start + i, ux[i], uy[i], uz[i]);
            }
        }
        report(source.wavelength_nm, source.n, cosine, bits);
    }
    aomc_sky_unload(&file);
    return 0;
}
