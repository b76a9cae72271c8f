/* source_driver.c on a GPU: the same functions over arrays of the host, each photon made by a thread of a kernel. */
#ifdef DRIVER_PEER /* cuRAND is not everywhere where nvcc is */
#include <curand_kernel.h>
#endif
#include <math.h>

#include "aomc_sky.h"

static aomc_sky_file file;
static aomc_sky_source source;
static void *bytes;

static int64_t failed(void)
{
    const cudaError_t status = cudaGetLastError();
    if (status != cudaSuccess) fprintf(stderr, "CUDA: %s\n", cudaGetErrorString(status));
    return status == cudaSuccess ? 0 : -1000;
}

/* Rows 0 to 5 of a photon: its direction and its numbers. */
__device__ void photon(const aomc_sky_source *s, int64_t i, float *row, int32_t *patch)
{
    const aomc_sky_photon p = aomc_sky_at(s, i);
    row[0] = p.ux, row[1] = p.uy, row[2] = p.uz, *patch = p.patch;
    aomc_sky_numbers_at(s, i, row + 3);
}
__device__ void photon(const aomc_sky_source *s, int64_t i, double *row, int32_t *patch)
{
    const aomc_sky_photon_double p = aomc_sky_at_double(s, i);
    row[0] = p.ux, row[1] = p.uy, row[2] = p.uz, *patch = p.patch;
    aomc_sky_numbers_at_double(s, i, row + 3);
}

template <typename T> __global__ void photons(aomc_sky_source s, const int64_t *index, int64_t n, T *rows, int32_t *patch)
{
    const int64_t j = blockIdx.x * (int64_t)blockDim.x + threadIdx.x;
    T row[6];
    if (j >= n) return;
    photon(&s, index[j], row, patch + j);
    for (int c = 0; c < 6; c++) rows[c * n + j] = row[c];
}

/* Photons start .. start + n are added up, so that a timing sees the photons and no memory. */
template <typename T> __global__ void add_up(aomc_sky_source s, int64_t start, int64_t n, double *sum)
{
    const int64_t step = gridDim.x * (int64_t)blockDim.x;
    double own = 0;
    for (int64_t j = blockIdx.x * (int64_t)blockDim.x + threadIdx.x; j < n; j += step) {
        T row[6];
        if (sizeof(T) == 4) {
            const aomc_sky_photon p = aomc_sky_at(&s, start + j);
            row[0] = p.ux, row[1] = p.uy, row[2] = p.uz;
        } else {
            const aomc_sky_photon_double p = aomc_sky_at_double(&s, start + j);
            row[0] = (T)p.ux, row[1] = (T)p.uy, row[2] = (T)p.uz;
        }
        own += row[0] + row[1] + row[2];
    }
    atomicAdd(sum, own);
}

#ifdef DRIVER_PEER
/* The peer of a timing: three numbers a photon of cuRAND's Philox, and no direction. */
__global__ void add_up_numbers(int64_t start, int64_t n, double *sum)
{
    const int64_t step = gridDim.x * (int64_t)blockDim.x;
    double own = 0;
    for (int64_t j = blockIdx.x * (int64_t)blockDim.x + threadIdx.x; j < n; j += step) {
        curandStatePhilox4_32_10_t state;
        curand_init(7, start + j, 0, &state);
        const float4 u = curand_uniform4(&state);
        own += u.x + u.y + u.z;
    }
    atomicAdd(sum, own);
}
#endif

__global__ void witness(aomc_sky_source s, int *code) { *code = aomc_sky_witness(&s); }

template <typename T> static int64_t made(const int64_t *index, int64_t n, T *rows, int32_t *patch)
{
    int64_t *on_index;
    T *on_rows;
    int32_t *on_patch;
    cudaMalloc(&on_index, n * sizeof *on_index);
    cudaMalloc(&on_rows, 6 * n * sizeof *on_rows);
    cudaMalloc(&on_patch, n * sizeof *on_patch);
    cudaMemcpy(on_index, index, n * sizeof *index, cudaMemcpyHostToDevice);
    photons<<<(unsigned)((n + 127) / 128), 128>>>(source, on_index, n, on_rows, on_patch);
    cudaMemcpy(rows, on_rows, 6 * n * sizeof *rows, cudaMemcpyDeviceToHost);
    cudaMemcpy(patch, on_patch, n * sizeof *patch, cudaMemcpyDeviceToHost);
    cudaFree(on_index), cudaFree(on_rows), cudaFree(on_patch);
    return failed();
}

template <typename T> static int64_t three_rows(int first, int64_t start, int64_t n, void *x, void *y, void *z)
{
    int64_t *index = (int64_t *)malloc(n * sizeof *index);
    T *rows = (T *)malloc(6 * n * sizeof *rows);
    int32_t *patch = (int32_t *)malloc(n * sizeof *patch);
    for (int64_t j = 0; j < n; j++) index[j] = start + j;
    const int64_t code = made<T>(index, n, rows, patch);
    memcpy(x, rows + first * n, n * sizeof *rows);
    memcpy(y, rows + (first + 1) * n, n * sizeof *rows);
    memcpy(z, rows + (first + 2) * n, n * sizeof *rows);
    free(index), free(rows), free(patch);
    return code < 0 ? code : n;
}

template <typename Launch> static double seconds(Launch launch)
{
    double *sum;
    float ms = 0;
    cudaEvent_t begin, end;
    cudaEventCreate(&begin), cudaEventCreate(&end);
    cudaMalloc(&sum, sizeof *sum);
    cudaMemset(sum, 0, sizeof *sum);
    launch(sum);
    cudaEventRecord(begin);
    launch(sum);
    cudaEventRecord(end);
    cudaEventSynchronize(end);
    cudaEventElapsedTime(&ms, begin, end);
    cudaFree(sum);
    return failed() < 0 ? NAN : ms * 1e-3;
}

extern "C" {

int driver_view(const void *data, uint64_t size)
{
    const int code = aomc_sky_view(data, size, &file);
    cudaFree(bytes);
    bytes = NULL;
    if (code != 0) return code;
    cudaMalloc(&bytes, size);
    cudaMemcpy(bytes, data, size, cudaMemcpyHostToDevice);
    return (int)failed();
}

int driver_load(const char *path)
{
    aomc_sky_file one;
    const int code = aomc_sky_load(path, &one);
    aomc_sky_unload(&one);
    return code;
}

int driver_band(int32_t band) { return aomc_sky_band_at(&file, band, bytes, &source); }

int64_t driver_n(void) { return source.n; }

int driver_witness(void)
{
    int code = -1, *on_device;
    cudaMalloc(&on_device, sizeof *on_device);
    witness<<<1, 1>>>(source, on_device);
    cudaMemcpy(&code, on_device, sizeof code, cudaMemcpyDeviceToHost);
    cudaFree(on_device);
    return failed() < 0 ? -1000 : code;
}

uint64_t driver_checksum(const void *data, uint64_t size) { return aomc_sky_checksum(data, size); }

const char *driver_message(int64_t code) { return aomc_sky_message(code); }

int64_t driver_fill(int is_double, int64_t start, int64_t n, void *x, void *y, void *z)
{
    return is_double ? three_rows<double>(0, start, n, x, y, z) : three_rows<float>(0, start, n, x, y, z);
}

int64_t driver_numbers(int is_double, int64_t start, int64_t n, void *n1, void *n2, void *n3)
{
    return is_double ? three_rows<double>(3, start, n, n1, n2, n3) : three_rows<float>(3, start, n, n1, n2, n3);
}

void driver_at(int is_double, const int64_t *index, int64_t n, void *rows, int32_t *patch)
{
    is_double ? made<double>(index, n, (double *)rows, patch) : made<float>(index, n, (float *)rows, patch);
}

/* Seconds of a kernel for n photons of the band, after one that was not timed; way 0 is float, 1 double, 2 the peer. */
double driver_seconds(int way, int64_t n)
{
    const int blocks = 2048, threads = 128;
#ifdef DRIVER_PEER
    if (way == 2) return seconds([=](double *sum) { add_up_numbers<<<blocks, threads>>>(0, n, sum); });
#endif
    if (way == 1) return seconds([=](double *sum) { add_up<double><<<blocks, threads>>>(source, 0, n, sum); });
    return seconds([=](double *sum) { add_up<float><<<blocks, threads>>>(source, 0, n, sum); });
}
}
