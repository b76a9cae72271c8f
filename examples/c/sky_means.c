/* The photons of a source file in a C program: the mean cosine of every waveband.
 *
 *     sky_means day.sky
 */
#include "example.h"

static float ux[BLOCK], uy[BLOCK], uz[BLOCK];

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
        need(aomc_sky_witness(&source)); /* this file was compiled as the bits want it */
        for (int64_t start = 0, n; (n = need(aomc_sky_fill(&source, start, BLOCK, ux, uy, uz))) > 0; start += n)
            for (int64_t i = 0; i < n; i++) { /* here your photon goes its way */
                cosine -= uz[i];
                bits ^= bits_of(start + i, ux[i], uy[i], uz[i]);
            }
        report(source.wavelength_nm, source.n, cosine, bits);
    }
    aomc_sky_unload(&file);
    return 0;
}
