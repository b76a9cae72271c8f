! The photons of a source file in a Fortran program, on all cores: the mean cosine of every waveband.
!
!     sky_means day.sky
program sky_means
    use, intrinsic :: iso_fortran_env, only: error_unit, int32, int64, real32, real64
    use aomc_sky
    implicit none
    integer, parameter :: block = 4096
    type(aomc_sky_file) :: file
    type(aomc_sky_source) :: source
    character(1000) :: path
    integer(int64) :: start, n, bits, i
    integer :: band
    real(real32) :: ux(block), uy(block), uz(block)
    real(real64) :: cosine

    call get_command_argument(1, path)
    n = aomc_sky_load(path, file)
    call need(n)
    do band = 0, file%n_bands - 1
        n = aomc_sky_band(file, band, source)
        call need(n)
        cosine = 0
        bits = 0
        !$omp parallel do private(n, i, ux, uy, uz) reduction(+: cosine) reduction(ieor: bits) schedule(dynamic)
        do start = 0, source%n - 1, block
            n = aomc_sky_fill(source, start, ux, uy, uz)
            call need(n)
            do i = 1, n ! here your photon goes its way
                cosine = cosine - uz(i)
                bits = ieor(bits, bits_of(start + i - 1, ux(i), uy(i), uz(i)))
            end do
        end do
        write (*, "(f8.2, a, i12, a, f8.6, a, z16.16)") source%wavelength_nm, " nm ", source%n, " photons, mean cosine ", &
            cosine / max(source%n, 1_int64), ", bits ", bits
    end do
    call aomc_sky_unload(file)

contains

    ! The bits of a photon, turned by its index: all together give the number of ../c/example.h. A host needs none of it.
    pure function bits_of(i, ux, uy, uz) result(word)
        integer(int64), intent(in) :: i
        real(real32), intent(in) :: ux, uy, uz
        integer(int64) :: word
        word = ieor(iand(int(transfer(ux, 0_int32), int64), 4294967295_int64), &
                    ieor(ishft(iand(int(transfer(uy, 0_int32), int64), 4294967295_int64), 16), &
                         ishft(int(transfer(uz, 0_int32), int64), 32)))
        word = ishftc(word, int(modulo(i, 63_int64)) + 1)
    end function

    subroutine need(code) ! a negative one ends the program with what it says
        integer(int64), intent(in) :: code
        if (code >= 0) return
        write (error_unit, "(2a)") "aomc-sky: ", aomc_sky_text(code)
        stop 1
    end subroutine
end program
