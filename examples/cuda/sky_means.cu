/* The photons of a source file on a GPU: the mean cosine of every waveband, each photon by a thread.
 *
 *     sky_means day.sky
 */
#include "../c/example.h"

/* A source goes to a kernel by value. Its pointers are addresses of the device. */
__global__ void follow(aomc_sky_source source, double *cosine, unsigned long long *bits)
{
    const int64_t first = blockIdx.x * (int64_t)blockDim.x + threadIdx.x, step = gridDim.x * (int64_t)blockDim.x;
    double own_cosine = 0;
    uint64_t own_bits = 0;
    for (int64_t i = first; i < source.n; i += step) {
        const aomc_sky_photon p = aomc_sky_at(&source, i); /* here your photon goes its way */
        own_cosine -= p.uz;
        own_bits ^= bits_of(i, p.ux, p.uy, p.uz);
    }
    atomicAdd(cosine, own_cosine);
    atomicXor(bits, (unsigned long long)own_bits);
}

/* Whether this GPU, and the code that nvcc made for it, gives the photons that the file knows. */
__global__ void try_witnesses(aomc_sky_source source, int *code) { *code = aomc_sky_witness(&source); }

static void cuda(cudaError_t status)
{
    if (status == cudaSuccess) return;
    fprintf(stderr, "CUDA: %s\n", cudaGetErrorString(status));
    exit(1);
}

struct Sums {
    double cosine;
    unsigned long long bits;
    int code;
};

int main(int argc, char **argv)
{
    aomc_sky_file file;
    void *bytes;
    Sums *sums;
    if (argc != 2) return fprintf(stderr, "usage: %s FILE\n", argv[0]), 2;
    need(aomc_sky_load(argv[1], &file));
    cuda(cudaMalloc(&bytes, file.size));
    cuda(cudaMemcpy(bytes, file.bytes, file.size, cudaMemcpyHostToDevice));
    cuda(cudaMallocManaged(&sums, sizeof *sums));
    for (int32_t band = 0; band < file.n_bands; band++) {
        aomc_sky_source source;
        need(aomc_sky_band_at(&file, band, bytes, &source));
        *sums = Sums();
        try_witnesses<<<1, 1>>>(source, &sums->code);
        follow<<<512, 128>>>(source, &sums->cosine, &sums->bits);
        cuda(cudaDeviceSynchronize());
        need(sums->code);
        report(source.wavelength_nm, source.n, sums->cosine, sums->bits);
    }
    cuda(cudaFree(bytes));
    aomc_sky_unload(&file);
}
