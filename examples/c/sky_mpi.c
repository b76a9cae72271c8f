/* The same on many nodes: rank 0 reads the file, MPI_Bcast spreads its bytes, every rank takes its own photons.
 *
 *     mpirun -n 8 sky_mpi day.sky
 */
#include <mpi.h>

#include "example.h"

static float ux[BLOCK], uy[BLOCK], uz[BLOCK];

/* One read for all ranks, of at most 2 GB; each rank tries the witnesses on its own processor. */
static int64_t spread(const char *path, int rank, aomc_sky_file *file)
{
    int64_t code = rank == 0 ? aomc_sky_load(path, file) : 0;
    uint64_t size = rank == 0 && code == 0 ? file->size : 0;
    MPI_Bcast(&code, 1, MPI_INT64_T, 0, MPI_COMM_WORLD);
    if (code < 0) return code;
    MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    void *bytes = rank == 0 ? (void *)file->bytes : malloc(size);
    if (!bytes) return AOMC_SKY_NO_MEMORY;
    MPI_Bcast(bytes, (int)size, MPI_BYTE, 0, MPI_COMM_WORLD);
    return rank == 0 ? 0 : aomc_sky_view(bytes, size, file);
}

int main(int argc, char **argv)
{
    aomc_sky_file file;
    aomc_sky_source source;
    int rank, ranks;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    need(argc == 2 ? spread(argv[1], rank, &file) : AOMC_SKY_NO_FILE);
    for (int32_t band = 0; band < file.n_bands; band++) {
        double cosine = 0, all_cosine = 0;
        uint64_t bits = 0, all_bits = 0;
        need(aomc_sky_band(&file, band, &source));
        for (int64_t start = (int64_t)rank * BLOCK; start < source.n; start += (int64_t)ranks * BLOCK) {
            const int64_t n = need(aomc_sky_fill(&source, start, BLOCK, ux, uy, uz));
            for (int64_t i = 0; i < n; i++) { /* here your photon goes its way */
                cosine -= uz[i];
                bits ^= bits_of(start + i, ux[i], uy[i], uz[i]);
            }
        }
        MPI_Reduce(&cosine, &all_cosine, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
        MPI_Reduce(&bits, &all_bits, 1, MPI_UINT64_T, MPI_BXOR, 0, MPI_COMM_WORLD);
        if (rank == 0) report(source.wavelength_nm, source.n, all_cosine, all_bits);
    }
    MPI_Finalize();
    return 0;
}
