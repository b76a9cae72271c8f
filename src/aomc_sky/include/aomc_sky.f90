! The photons of aomc-sky from a file, without Python: the functions of aomc_sky.h for Fortran 2018.
!
!     cc -O3 -c aomc_sky.c
!     gfortran -O3 -c aomc_sky.f90
!
! Bands and photons count from 0, as in C. Codes are those of aomc_sky.h, and aomc_sky_message says what they mean.
!
!     type(aomc_sky_file) :: file
!     type(aomc_sky_source) :: source
!     code = aomc_sky_load("day.sky"//c_null_char, file)
!     if (code == 0) code = aomc_sky_band(file, 0_c_int32_t, source)
!     if (code /= 0) error stop aomc_sky_text(int(code, c_int64_t))
!     n = aomc_sky_fill(source, 0_c_int64_t, size(ux, kind=c_int64_t), ux, uy, uz)
module aomc_sky
    use, intrinsic :: iso_c_binding
    implicit none
    private
    public :: aomc_sky_file, aomc_sky_source, aomc_sky_photon, aomc_sky_photon_double, aomc_sky_load, aomc_sky_view, &
        aomc_sky_unload, aomc_sky_band, aomc_sky_at, aomc_sky_at_double, aomc_sky_fill, aomc_sky_fill_double, &
        aomc_sky_weighted_band, aomc_sky_replicate, aomc_sky_weighted_replicate, aomc_sky_weight, &
        aomc_sky_weight_double, aomc_sky_component, aomc_sky_fill_weighted, &
        aomc_sky_fill_weighted_double, &
        aomc_sky_stream, aomc_sky_particle, aomc_sky_particles, aomc_sky_next, &
        aomc_sky_position, aomc_sky_position_double, aomc_sky_positions, aomc_sky_positions_double, &
        aomc_sky_numbers, aomc_sky_numbers_double, aomc_sky_numbers_at, aomc_sky_numbers_at_double, &
        aomc_sky_witness, aomc_sky_checksum, aomc_sky_text

    type, bind(C) :: aomc_sky_file
        type(c_ptr) :: bytes
        integer(c_int64_t) :: size
        integer(c_int32_t) :: n_bands, precision
        character(kind=c_char) :: plan_sha256(65), is_owned, reserve(2)
        integer(c_int32_t) :: n_replicates
    end type

    ! After these the fields are those of C; their words have the size that C says.
    type, bind(C) :: aomc_sky_source
        integer(c_int64_t) :: n
        real(c_double) :: wavelength_nm, irradiance_W_m2_nm
        type(c_ptr) :: stokes
        real(c_double) :: photon_light
        integer(c_int64_t) :: rest(59)
    end type

    type, bind(C) :: aomc_sky_photon
        real(c_float) :: ux, uy, uz
        integer(c_int32_t) :: patch
    end type

    type, bind(C) :: aomc_sky_photon_double
        real(c_double) :: ux, uy, uz
        integer(c_int32_t) :: patch
    end type

    ! A photon of a stream; its weight is its light.
    type, bind(C) :: aomc_sky_particle
        real(c_double) :: ux, uy, uz, weight, x, y
        integer(c_int64_t) :: index
        integer(c_int32_t) :: band, patch, component, reserve
    end type

    type, bind(C) :: aomc_sky_stream
        integer(c_int64_t) :: n, at, to
        integer(c_int64_t) :: rest(1805)
    end type

    interface
        integer(c_int) function aomc_sky_load(path, file) bind(C)
            import :: aomc_sky_file, c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
            type(aomc_sky_file), intent(out) :: file
        end function

        ! Bytes that are in memory, aligned to 8 bytes, as MPI_Bcast leaves them; they must stay and not change.
        integer(c_int) function aomc_sky_view(bytes, size, file) bind(C)
            import :: aomc_sky_file, c_int, c_int64_t, c_ptr
            type(c_ptr), value :: bytes
            integer(c_int64_t), value :: size
            type(aomc_sky_file), intent(out) :: file
        end function

        subroutine aomc_sky_unload(file) bind(C)
            import :: aomc_sky_file
            type(aomc_sky_file), intent(inout) :: file
        end subroutine

        integer(c_int) function aomc_sky_band(file, band, source) bind(C)
            import :: aomc_sky_file, aomc_sky_source, c_int, c_int32_t
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band
            type(aomc_sky_source), intent(out) :: source
        end function

        ! For a host that counts each photon with its weight; aomc_sky_band has a code for a band with weights.
        integer(c_int) function aomc_sky_weighted_band(file, band, source) bind(C)
            import :: aomc_sky_file, aomc_sky_source, c_int, c_int32_t
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band
            type(aomc_sky_source), intent(out) :: source
        end function

        ! The band of one replicate, from 0 to file%n_replicates - 1.
        integer(c_int) function aomc_sky_replicate(file, band, replicate, source) bind(C)
            import :: aomc_sky_file, aomc_sky_source, c_int, c_int32_t
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band, replicate
            type(aomc_sky_source), intent(out) :: source
        end function

        integer(c_int) function aomc_sky_weighted_replicate(file, band, replicate, source) bind(C)
            import :: aomc_sky_file, aomc_sky_source, c_int, c_int32_t
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band, replicate
            type(aomc_sky_source), intent(out) :: source
        end function

        type(aomc_sky_photon) function aomc_sky_at(source, i) bind(C)
            import :: aomc_sky_photon, aomc_sky_source, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
        end function

        type(aomc_sky_photon_double) function aomc_sky_at_double(source, i) bind(C)
            import :: aomc_sky_photon_double, aomc_sky_source, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
        end function

        integer(c_int64_t) function aomc_sky_fill(source, start, n, ux, uy, uz) bind(C)
            import :: aomc_sky_source, c_float, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_float), intent(out) :: ux(*), uy(*), uz(*)
        end function

        integer(c_int64_t) function aomc_sky_fill_double(source, start, n, ux, uy, uz) bind(C)
            import :: aomc_sky_source, c_double, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_double), intent(out) :: ux(*), uy(*), uz(*)
        end function

        ! Weight of a photon that aomc_sky_at gave, 1 where a file has none.
        real(c_double) function aomc_sky_weight(source, photon) bind(C)
            import :: aomc_sky_photon, aomc_sky_source, c_double
            type(aomc_sky_source), intent(in) :: source
            type(aomc_sky_photon), value :: photon
        end function

        real(c_double) function aomc_sky_weight_double(source, photon) bind(C)
            import :: aomc_sky_photon_double, aomc_sky_source, c_double
            type(aomc_sky_source), intent(in) :: source
            type(aomc_sky_photon_double), value :: photon
        end function

        ! Number of the component of a patch, from 0.

        integer(c_int32_t) function aomc_sky_component(source, patch) bind(C)
            import :: aomc_sky_source, c_int32_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int32_t), value :: patch
        end function

        ! aomc_sky_fill, and patch and weight of each photon; one that is left out is not made.
        integer(c_int64_t) function aomc_sky_fill_weighted(source, start, n, ux, uy, uz, patch, weight) &
            bind(C)
            import :: aomc_sky_source, c_float, c_int32_t, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_float), intent(inout) :: ux(*), uy(*), uz(*)
            integer(c_int32_t), intent(inout), optional :: patch(*)
            real(c_float), intent(inout), optional :: weight(*)
        end function

        integer(c_int64_t) function aomc_sky_fill_weighted_double(source, start, n, ux, uy, uz, patch, weight) &
            bind(C)
            import :: aomc_sky_source, c_double, c_int32_t, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_double), intent(inout) :: ux(*), uy(*), uz(*)
            integer(c_int32_t), intent(inout), optional :: patch(*)
            real(c_double), intent(inout), optional :: weight(*)
        end function

        ! A stream over the photons of all sources from place `from`, counted from 0, to before `to`. The stream leads to
        ! the sources, which are a whole array with the attribute target; each thread has a stream of its own.
        integer(c_int) function aomc_sky_particles(stream, sources, n_sources, from, to) bind(C)
            import :: aomc_sky_source, aomc_sky_stream, c_int, c_int32_t, c_int64_t
            type(aomc_sky_stream), intent(inout) :: stream
            type(aomc_sky_source), intent(in), target :: sources(*)
            integer(c_int32_t), value :: n_sources
            integer(c_int64_t), value :: from, to
        end function

        ! The next particle: 1; 0 at the end of the stream; or a code.
        integer(c_int) function aomc_sky_next(stream, particle) bind(C)
            import :: aomc_sky_particle, aomc_sky_stream, c_int
            type(aomc_sky_stream), intent(inout) :: stream
            type(aomc_sky_particle), intent(inout) :: particle
        end function

        ! Positions on the surface [m]; an argument that is left out is not made.
        integer(c_int64_t) function aomc_sky_positions(source, start, n, x, y) bind(C)
            import :: aomc_sky_source, c_float, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_float), intent(inout), optional :: x(*), y(*)
        end function

        integer(c_int64_t) function aomc_sky_positions_double(source, start, n, x, y) bind(C)
            import :: aomc_sky_source, c_double, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_double), intent(inout), optional :: x(*), y(*)
        end function

        subroutine aomc_sky_position(source, i, xy) bind(C)
            import :: aomc_sky_source, c_float, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_float), intent(inout) :: xy(2)
        end subroutine

        subroutine aomc_sky_position_double(source, i, xy) bind(C)
            import :: aomc_sky_source, c_double, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_double), intent(inout) :: xy(2)
        end subroutine

        ! The photons' further numbers; an argument that is left out is not made.
        integer(c_int64_t) function aomc_sky_numbers(source, start, n, n1, n2, n3) bind(C)
            import :: aomc_sky_source, c_float, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_float), intent(out), optional :: n1(*), n2(*), n3(*)
        end function

        integer(c_int64_t) function aomc_sky_numbers_double(source, start, n, n1, n2, n3) bind(C)
            import :: aomc_sky_source, c_double, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_double), intent(out), optional :: n1(*), n2(*), n3(*)
        end function

        subroutine aomc_sky_numbers_at(source, i, numbers) bind(C)
            import :: aomc_sky_source, c_float, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_float), intent(out) :: numbers(3)
        end subroutine

        subroutine aomc_sky_numbers_at_double(source, i, numbers) bind(C)
            import :: aomc_sky_source, c_double, c_int64_t
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_double), intent(out) :: numbers(3)
        end subroutine

        integer(c_int) function aomc_sky_witness(source) bind(C)
            import :: aomc_sky_source, c_int
            type(aomc_sky_source), intent(in) :: source
        end function

        integer(c_int64_t) function aomc_sky_checksum(bytes, size) bind(C)
            import :: c_int64_t, c_ptr
            type(c_ptr), value :: bytes
            integer(c_int64_t), value :: size
        end function

        type(c_ptr) function aomc_sky_message(code) bind(C)
            import :: c_int64_t, c_ptr
            integer(c_int64_t), value :: code
        end function
    end interface

contains

    ! What a code says: aomc_sky_message as a text of Fortran.
    function aomc_sky_text(code) result(text)
        integer(c_int64_t), intent(in) :: code
        character(len=:), allocatable :: text
        character(kind=c_char), pointer :: letters(:)
        integer :: n
        call c_f_pointer(aomc_sky_message(code), letters, [400])
        n = 0
        do while (letters(n + 1) /= c_null_char)
            n = n + 1
        end do
        allocate (character(len=n) :: text)
        text = transfer(letters(:n), text)
    end function
end module
