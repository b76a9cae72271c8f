! The photons of aomc-sky from a file, without Python: the functions of aomc_sky.h for Fortran 2018.
!
!     cc -O3 -c aomc_sky.c
!     gfortran -O3 -c aomc_sky.f90
!
!     type(aomc_sky_file) :: file
!     type(aomc_sky_source) :: source
!     code = aomc_sky_load("day.sky", file)
!     if (code == 0) code = aomc_sky_band(file, 0, source)
!     if (code /= 0) error stop aomc_sky_text(code)
!     n = aomc_sky_fill(source, 0, ux, uy, uz)
!
! Bands and photons count from 0, as in C. Codes are those of aomc_sky.h, and aomc_sky_text says what they mean.
! Numbers that go in are integers of 32 or 64 bits, so that programs compile with -fdefault-integer-8, too. `class(*)`
! takes both; a number of another type stops the program.
! Arrays are real32 or real64, as the file is, and may be strided. The names with _double take real64 alone.
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

    ! The codes of aomc_sky.h. Letters have no case here, so one code cannot have the name of the function for checksums.
    integer(c_int), parameter, public :: &
        AOMC_SKY_NO_FILE = -1, AOMC_SKY_NO_MEMORY = -2, AOMC_SKY_NULL = -3, AOMC_SKY_NOT_OURS = -4, &
        AOMC_SKY_NEWER = -5, AOMC_SKY_STREAMS = -6, AOMC_SKY_SIZE = -7, AOMC_SKY_BAD_CHECKSUM = -8, &
        AOMC_SKY_DIRECTORY = -9, AOMC_SKY_TABLE = -10, AOMC_SKY_ARITHMETIC = -11, AOMC_SKY_NO_BAND = -12, &
        AOMC_SKY_OTHER = -13, AOMC_SKY_RANGE = -14, AOMC_SKY_TRIALS = -15, AOMC_SKY_WEIGHTS = -16, &
        AOMC_SKY_UNITS = -17, AOMC_SKY_REPLICATES = -18

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
        integer(c_int64_t) :: rest(2061)
    end type

    ! Directions of the photons from `start` on, and patch and weight of each, which may be left out. Returns the number of
    ! photons, 0 at the end of the band, or a code. Numbers behind the last photon stay as they were.
    !     aomc_sky_fill(source, start, ux, uy, uz [, patch, weight])       at most as many as the smallest array holds
    !     aomc_sky_fill(source, start, u [, patch, weight])                u(3, n), photon by photon
    !     aomc_sky_fill(source, start, n, ux, uy, uz [, patch, weight])    at most n
    interface aomc_sky_fill
        procedure fill_f, fill_f_rows, fill_f_n, fill_d, fill_d_rows, fill_d_n
    end interface
    interface aomc_sky_fill_weighted
        procedure fill_f, fill_f_rows, fill_f_n, fill_d, fill_d_rows, fill_d_n
    end interface
    interface aomc_sky_fill_double
        procedure fill_d, fill_d_rows, fill_d_n
    end interface
    interface aomc_sky_fill_weighted_double
        procedure fill_d, fill_d_rows, fill_d_n
    end interface

    ! The photons' further numbers: (source, start [, n], n1, n2, n3). Any of the three may be left out, but for n1 of
    ! real64: if every array could be missing, a compiler would not know which kind is meant.
    interface aomc_sky_numbers
        procedure numbers_f, numbers_f_n, numbers_d_from_1, numbers_d_from_1_n
    end interface
    interface aomc_sky_numbers_double
        procedure numbers_d, numbers_d_n
    end interface

    ! Positions on the surface [m]: (source, start [, n], x, y). Either may be left out, but for x of real64.
    interface aomc_sky_positions
        procedure positions_f, positions_f_n, positions_d_from_x, positions_d_from_x_n
    end interface
    interface aomc_sky_positions_double
        procedure positions_d, positions_d_n
    end interface

    ! A stream over the photons of all sources from place `from`, counted from 0, to before `to`, or to the end:
    !     aomc_sky_particles(stream, sources [, from, to])
    !     aomc_sky_particles(stream, sources, n_sources, from, to)
    ! Each thread has a stream of its own. The stream keeps the address of the sources. A copy of them that a compiler
    ! makes for the call would be gone when the stream reads it. So they are a pointer argument, which is never a copy:
    ! a program whose sources lack the attribute target is not compiled.
    interface aomc_sky_particles
        procedure particles, particles_n
    end interface

    interface aomc_sky_at
        procedure c_at, at_of_32_bits
    end interface
    interface aomc_sky_at_double
        procedure c_at_double, at_double_of_32_bits
    end interface

    ! Weight of a photon that aomc_sky_at gave, 1 where a file has none.
    interface aomc_sky_weight
        procedure c_weight, c_weight_double
    end interface
    interface aomc_sky_weight_double
        procedure c_weight_double
    end interface

    ! Number of the component of a patch, from 0.
    interface aomc_sky_component
        procedure c_component, component_of_64_bits
    end interface

    interface aomc_sky_position
        procedure c_position, c_position_double, position_f_of_32_bits, position_d_of_32_bits
    end interface
    interface aomc_sky_position_double
        procedure c_position_double, position_d_of_32_bits
    end interface

    interface aomc_sky_numbers_at
        procedure c_numbers_at, c_numbers_at_double, numbers_at_f_of_32_bits, numbers_at_d_of_32_bits
    end interface
    interface aomc_sky_numbers_at_double
        procedure c_numbers_at_double, numbers_at_d_of_32_bits
    end interface

    interface
        subroutine aomc_sky_unload(file) bind(C)
            import
            type(aomc_sky_file), intent(inout) :: file
        end subroutine

        ! The next particle: 1; 0 at the end of the stream; or a code.
        integer(c_int) function aomc_sky_next(stream, particle) bind(C)
            import
            type(aomc_sky_stream), intent(inout) :: stream
            type(aomc_sky_particle), intent(inout) :: particle
        end function

        integer(c_int) function aomc_sky_witness(source) bind(C)
            import
            type(aomc_sky_source), intent(in) :: source
        end function

        integer(c_int) function c_load(path, file) bind(C, name="aomc_sky_load")
            import
            character(kind=c_char), intent(in) :: path(*)
            type(aomc_sky_file), intent(inout) :: file
        end function

        integer(c_int) function c_view(bytes, size, file) bind(C, name="aomc_sky_view")
            import
            type(c_ptr), value :: bytes
            integer(c_int64_t), value :: size
            type(aomc_sky_file), intent(inout) :: file
        end function

        integer(c_int) function c_band(file, band, source) bind(C, name="aomc_sky_band")
            import
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band
            type(aomc_sky_source), intent(inout) :: source
        end function

        integer(c_int) function c_weighted_band(file, band, source) bind(C, name="aomc_sky_weighted_band")
            import
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band
            type(aomc_sky_source), intent(inout) :: source
        end function

        integer(c_int) function c_replicate(file, band, replicate, source) bind(C, name="aomc_sky_replicate")
            import
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band, replicate
            type(aomc_sky_source), intent(inout) :: source
        end function

        integer(c_int) function c_weighted_replicate(file, band, replicate, source) &
            bind(C, name="aomc_sky_weighted_replicate")
            import
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band, replicate
            type(aomc_sky_source), intent(inout) :: source
        end function

        type(aomc_sky_photon) function c_at(source, i) bind(C, name="aomc_sky_at")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
        end function

        type(aomc_sky_photon_double) function c_at_double(source, i) bind(C, name="aomc_sky_at_double")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
        end function

        real(c_double) function c_weight(source, photon) bind(C, name="aomc_sky_weight")
            import
            type(aomc_sky_source), intent(in) :: source
            type(aomc_sky_photon), value :: photon
        end function

        real(c_double) function c_weight_double(source, photon) bind(C, name="aomc_sky_weight_double")
            import
            type(aomc_sky_source), intent(in) :: source
            type(aomc_sky_photon_double), value :: photon
        end function

        integer(c_int32_t) function c_component(source, patch) bind(C, name="aomc_sky_component")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int32_t), value :: patch
        end function

        subroutine c_position(source, i, xy) bind(C, name="aomc_sky_position")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_float), intent(inout) :: xy(2)
        end subroutine

        subroutine c_position_double(source, i, xy) bind(C, name="aomc_sky_position_double")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_double), intent(inout) :: xy(2)
        end subroutine

        subroutine c_numbers_at(source, i, numbers) bind(C, name="aomc_sky_numbers_at")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_float), intent(inout) :: numbers(3)
        end subroutine

        subroutine c_numbers_at_double(source, i, numbers) bind(C, name="aomc_sky_numbers_at_double")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            real(c_double), intent(inout) :: numbers(3)
        end subroutine

        ! Columns go to C by their addresses, so that the compiler copies none of them.
        integer(c_int64_t) function c_fill(source, start, n, ux, uy, uz, patch, weight) &
            bind(C, name="aomc_sky_fill_weighted")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            type(c_ptr), value :: ux, uy, uz, patch, weight
        end function

        integer(c_int64_t) function c_fill_double(source, start, n, ux, uy, uz, patch, weight) &
            bind(C, name="aomc_sky_fill_weighted_double")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            type(c_ptr), value :: ux, uy, uz, patch, weight
        end function

        integer(c_int64_t) function c_numbers(source, start, n, n1, n2, n3) bind(C, name="aomc_sky_numbers")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            type(c_ptr), value :: n1, n2, n3
        end function

        integer(c_int64_t) function c_numbers_double(source, start, n, n1, n2, n3) &
            bind(C, name="aomc_sky_numbers_double")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            type(c_ptr), value :: n1, n2, n3
        end function

        integer(c_int64_t) function c_positions(source, start, n, x, y) bind(C, name="aomc_sky_positions")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            type(c_ptr), value :: x, y
        end function

        integer(c_int64_t) function c_positions_double(source, start, n, x, y) bind(C, name="aomc_sky_positions_double")
            import
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            type(c_ptr), value :: x, y
        end function

        integer(c_int) function c_particles(stream, sources, n_sources, from, to) bind(C, name="aomc_sky_particles")
            import
            type(aomc_sky_stream), intent(inout) :: stream
            type(c_ptr), value :: sources
            integer(c_int32_t), value :: n_sources
            integer(c_int64_t), value :: from, to
        end function

        integer(c_int64_t) function c_checksum(bytes, size) bind(C, name="aomc_sky_checksum")
            import
            type(c_ptr), value :: bytes
            integer(c_int64_t), value :: size
        end function

        type(c_ptr) function c_message(code) bind(C, name="aomc_sky_message")
            import
            integer(c_int64_t), value :: code
        end function
    end interface

    ! What columns hold, of which precision, and how many photons a block has where columns are strided.
    integer, parameter :: DIRECTIONS = 10, NUMBERS = 20, PLACES = 30, OF_FLOATS = 4, OF_DOUBLES = 8, BLOCK = 512
    integer(c_int64_t), parameter :: NO_LIMIT = huge(1_c_int64_t)

contains

    ! Blanks at the end of the path do not belong to it. A path may end with achar(0), as it had to in earlier versions.
    integer(c_int) function aomc_sky_load(path, file) result(code)
        character(*), intent(in) :: path
        type(aomc_sky_file), intent(inout) :: file
        code = c_load(trim(path)//c_null_char, file)
    end function

    ! Bytes that are in memory, aligned to 8 bytes, as MPI_Bcast leaves them; they must stay and not change.
    integer(c_int) function aomc_sky_view(bytes, size, file) result(code)
        type(c_ptr), intent(in) :: bytes
        class(*), intent(in) :: size
        type(aomc_sky_file), intent(inout) :: file
        code = c_view(bytes, max(whole(size), 0_c_int64_t), file)
    end function

    integer(c_int64_t) function aomc_sky_checksum(bytes, size) result(word)
        type(c_ptr), intent(in) :: bytes
        class(*), intent(in) :: size
        word = c_checksum(bytes, max(whole(size), 0_c_int64_t))
    end function

    integer(c_int) function aomc_sky_band(file, band, source) result(code)
        type(aomc_sky_file), intent(in) :: file
        class(*), intent(in) :: band
        type(aomc_sky_source), intent(inout) :: source
        code = c_band(file, narrow(band), source)
    end function

    ! For a host that counts each photon with its weight; aomc_sky_band has a code for a band with weights.
    integer(c_int) function aomc_sky_weighted_band(file, band, source) result(code)
        type(aomc_sky_file), intent(in) :: file
        class(*), intent(in) :: band
        type(aomc_sky_source), intent(inout) :: source
        code = c_weighted_band(file, narrow(band), source)
    end function

    ! The band of one replicate, from 0 to file%n_replicates - 1.
    integer(c_int) function aomc_sky_replicate(file, band, replicate, source) result(code)
        type(aomc_sky_file), intent(in) :: file
        class(*), intent(in) :: band, replicate
        type(aomc_sky_source), intent(inout) :: source
        code = c_replicate(file, narrow(band), narrow(replicate), source)
    end function

    integer(c_int) function aomc_sky_weighted_replicate(file, band, replicate, source) result(code)
        type(aomc_sky_file), intent(in) :: file
        class(*), intent(in) :: band, replicate
        type(aomc_sky_source), intent(inout) :: source
        code = c_weighted_replicate(file, narrow(band), narrow(replicate), source)
    end function

    ! What a code says.
    function aomc_sky_text(code) result(text)
        class(*), intent(in) :: code
        character(len=:), allocatable :: text
        character(kind=c_char), pointer :: letters(:)
        integer :: n
        call c_f_pointer(c_message(whole(code)), letters, [400])
        n = 0
        do while (letters(n + 1) /= c_null_char)
            n = n + 1
        end do
        allocate (character(len=n) :: text)
        text = transfer(letters(:n), text)
    end function

    type(aomc_sky_photon) function at_of_32_bits(source, i) result(photon)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int32_t), intent(in) :: i
        photon = c_at(source, int(i, c_int64_t))
    end function

    type(aomc_sky_photon_double) function at_double_of_32_bits(source, i) result(photon)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int32_t), intent(in) :: i
        photon = c_at_double(source, int(i, c_int64_t))
    end function

    integer(c_int32_t) function component_of_64_bits(source, patch) result(component)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: patch
        component = c_component(source, narrow(patch))
    end function

    subroutine position_f_of_32_bits(source, i, xy)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int32_t), intent(in) :: i
        real(c_float), intent(inout) :: xy(2)
        call c_position(source, int(i, c_int64_t), xy)
    end subroutine

    subroutine position_d_of_32_bits(source, i, xy)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int32_t), intent(in) :: i
        real(c_double), intent(inout) :: xy(2)
        call c_position_double(source, int(i, c_int64_t), xy)
    end subroutine

    subroutine numbers_at_f_of_32_bits(source, i, numbers)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int32_t), intent(in) :: i
        real(c_float), intent(inout) :: numbers(3)
        call c_numbers_at(source, int(i, c_int64_t), numbers)
    end subroutine

    subroutine numbers_at_d_of_32_bits(source, i, numbers)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int32_t), intent(in) :: i
        real(c_double), intent(inout) :: numbers(3)
        call c_numbers_at_double(source, int(i, c_int64_t), numbers)
    end subroutine

    integer(c_int) function particles(stream, sources, from, to) result(code)
        type(aomc_sky_stream), intent(inout) :: stream
        type(aomc_sky_source), pointer, intent(in) :: sources(:)
        class(*), intent(in), optional :: from, to
        integer(c_int64_t) :: first, last
        first = 0
        last = NO_LIMIT
        if (present(from)) first = whole(from)
        if (present(to)) last = whole(to)
        code = particles_n(stream, sources, size(sources), first, last)
    end function

    integer(c_int) function particles_n(stream, sources, n_sources, from, to) result(code)
        type(aomc_sky_stream), intent(inout) :: stream
        type(aomc_sky_source), pointer, intent(in) :: sources(:)
        class(*), intent(in) :: n_sources, from, to
        type(aomc_sky_source), target :: none
        type(c_ptr) :: first
        integer(c_int32_t) :: n
        if (.not. is_contiguous(sources)) error stop "aomc_sky_particles: the sources do not follow each other in memory"
        n = narrow(n_sources)
        if (n > size(sources)) n = 0 ! no such band
        first = c_loc(none)
        if (size(sources) > 0) first = c_loc(sources(lbound(sources, 1)))
        code = c_particles(stream, first, n, whole(from), whole(to))
    end function

    integer(c_int64_t) function fill_f(source, start, ux, uy, uz, patch, weight) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_float), intent(inout) :: ux(:), uy(:), uz(:)
        integer(c_int32_t), intent(inout), optional :: patch(:)
        real(c_float), intent(inout), optional :: weight(:)
        made = columns_f(DIRECTIONS, source, whole(start), NO_LIMIT, ux, uy, uz, patch, weight)
    end function

    integer(c_int64_t) function fill_f_n(source, start, n, ux, uy, uz, patch, weight) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_float), intent(inout) :: ux(:), uy(:), uz(:)
        integer(c_int32_t), intent(inout), optional :: patch(:)
        real(c_float), intent(inout), optional :: weight(:)
        made = columns_f(DIRECTIONS, source, whole(start), whole(n), ux, uy, uz, patch, weight)
    end function

    integer(c_int64_t) function fill_f_rows(source, start, u, patch, weight) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_float), intent(inout) :: u(:, :)
        integer(c_int32_t), intent(inout), optional :: patch(:)
        real(c_float), intent(inout), optional :: weight(:)
        if (size(u, 1) /= 3) error stop "aomc_sky_fill: u has another shape than u(3, n)"
        made = columns_f(DIRECTIONS, source, whole(start), NO_LIMIT, u(1, :), u(2, :), u(3, :), patch, weight)
    end function

    integer(c_int64_t) function fill_d(source, start, ux, uy, uz, patch, weight) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_double), intent(inout) :: ux(:), uy(:), uz(:)
        integer(c_int32_t), intent(inout), optional :: patch(:)
        real(c_double), intent(inout), optional :: weight(:)
        made = columns_d(DIRECTIONS, source, whole(start), NO_LIMIT, ux, uy, uz, patch, weight)
    end function

    integer(c_int64_t) function fill_d_n(source, start, n, ux, uy, uz, patch, weight) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_double), intent(inout) :: ux(:), uy(:), uz(:)
        integer(c_int32_t), intent(inout), optional :: patch(:)
        real(c_double), intent(inout), optional :: weight(:)
        made = columns_d(DIRECTIONS, source, whole(start), whole(n), ux, uy, uz, patch, weight)
    end function

    integer(c_int64_t) function fill_d_rows(source, start, u, patch, weight) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_double), intent(inout) :: u(:, :)
        integer(c_int32_t), intent(inout), optional :: patch(:)
        real(c_double), intent(inout), optional :: weight(:)
        if (size(u, 1) /= 3) error stop "aomc_sky_fill: u has another shape than u(3, n)"
        made = columns_d(DIRECTIONS, source, whole(start), NO_LIMIT, u(1, :), u(2, :), u(3, :), patch, weight)
    end function

    integer(c_int64_t) function numbers_f(source, start, n1, n2, n3) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_float), intent(inout), optional :: n1(:), n2(:), n3(:)
        made = columns_f(NUMBERS, source, whole(start), NO_LIMIT, n1, n2, n3)
    end function

    integer(c_int64_t) function numbers_f_n(source, start, n, n1, n2, n3) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_float), intent(inout), optional :: n1(:), n2(:), n3(:)
        made = columns_f(NUMBERS, source, whole(start), whole(n), n1, n2, n3)
    end function

    integer(c_int64_t) function numbers_d(source, start, n1, n2, n3) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_double), intent(inout), optional :: n1(:), n2(:), n3(:)
        made = columns_d(NUMBERS, source, whole(start), NO_LIMIT, n1, n2, n3)
    end function

    integer(c_int64_t) function numbers_d_n(source, start, n, n1, n2, n3) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_double), intent(inout), optional :: n1(:), n2(:), n3(:)
        made = columns_d(NUMBERS, source, whole(start), whole(n), n1, n2, n3)
    end function

    integer(c_int64_t) function numbers_d_from_1(source, start, n1, n2, n3) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_double), intent(inout) :: n1(:)
        real(c_double), intent(inout), optional :: n2(:), n3(:)
        made = columns_d(NUMBERS, source, whole(start), NO_LIMIT, n1, n2, n3)
    end function

    integer(c_int64_t) function numbers_d_from_1_n(source, start, n, n1, n2, n3) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_double), intent(inout) :: n1(:)
        real(c_double), intent(inout), optional :: n2(:), n3(:)
        made = columns_d(NUMBERS, source, whole(start), whole(n), n1, n2, n3)
    end function

    integer(c_int64_t) function positions_f(source, start, x, y) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_float), intent(inout), optional :: x(:), y(:)
        made = columns_f(PLACES, source, whole(start), NO_LIMIT, x, y)
    end function

    integer(c_int64_t) function positions_f_n(source, start, n, x, y) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_float), intent(inout), optional :: x(:), y(:)
        made = columns_f(PLACES, source, whole(start), whole(n), x, y)
    end function

    integer(c_int64_t) function positions_d(source, start, x, y) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_double), intent(inout), optional :: x(:), y(:)
        made = columns_d(PLACES, source, whole(start), NO_LIMIT, x, y)
    end function

    integer(c_int64_t) function positions_d_n(source, start, n, x, y) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_double), intent(inout), optional :: x(:), y(:)
        made = columns_d(PLACES, source, whole(start), whole(n), x, y)
    end function

    integer(c_int64_t) function positions_d_from_x(source, start, x, y) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start
        real(c_double), intent(inout) :: x(:)
        real(c_double), intent(inout), optional :: y(:)
        made = columns_d(PLACES, source, whole(start), NO_LIMIT, x, y)
    end function

    integer(c_int64_t) function positions_d_from_x_n(source, start, n, x, y) result(made)
        type(aomc_sky_source), intent(in) :: source
        class(*), intent(in) :: start, n
        real(c_double), intent(inout) :: x(:)
        real(c_double), intent(inout), optional :: y(:)
        made = columns_d(PLACES, source, whole(start), whole(n), x, y)
    end function

    ! Columns of the photons from `start` on, at most n, as many as the smallest array holds. C writes into the arrays
    ! where all of them are contiguous, else into a block on the stack, from which photons are copied: no array is copied
    ! as a whole. `recursive` keeps the block on the stack, so that each thread has its own.
    recursive function columns_f(what, source, start, n, a, b, c, patch, weight) result(made)
        integer, intent(in) :: what
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: start, n
        real(c_float), intent(inout), optional, target :: a(:), b(:), c(:), weight(:)
        integer(c_int32_t), intent(inout), optional, target :: patch(:)
        real(c_float), target :: part(BLOCK, 4)
        integer(c_int32_t), target :: patches(BLOCK)
        integer(c_int64_t) :: made, room, now, k
        logical :: is_whole
        room = n
        is_whole = .true.
        call look(a, room, is_whole)
        call look(b, room, is_whole)
        call look(c, room, is_whole)
        call look(patch, room, is_whole)
        call look(weight, room, is_whole)
        if (is_whole) then
            made = by_c(what + OF_FLOATS, source, start, room, place(a), place(b), place(c), place(patch), place(weight))
            return
        end if
        made = 0
        do
            now = by_c(what + OF_FLOATS, source, start + made, min(room - made, int(BLOCK, c_int64_t)), &
                place(part(:, 1), present(a)), place(part(:, 2), present(b)), place(part(:, 3), present(c)), &
                place(patches, present(patch)), place(part(:, 4), present(weight)))
            if (now <= 0) exit
            do k = 1, now
                if (present(a)) a(made + k) = part(k, 1)
                if (present(b)) b(made + k) = part(k, 2)
                if (present(c)) c(made + k) = part(k, 3)
                if (present(patch)) patch(made + k) = patches(k)
                if (present(weight)) weight(made + k) = part(k, 4)
            end do
            made = made + now
            if (made == room) exit
        end do
        if (now < 0) made = now
    end function

    recursive function columns_d(what, source, start, n, a, b, c, patch, weight) result(made)
        integer, intent(in) :: what
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: start, n
        real(c_double), intent(inout), optional, target :: a(:), b(:), c(:), weight(:)
        integer(c_int32_t), intent(inout), optional, target :: patch(:)
        real(c_double), target :: part(BLOCK, 4)
        integer(c_int32_t), target :: patches(BLOCK)
        integer(c_int64_t) :: made, room, now, k
        logical :: is_whole
        room = n
        is_whole = .true.
        call look(a, room, is_whole)
        call look(b, room, is_whole)
        call look(c, room, is_whole)
        call look(patch, room, is_whole)
        call look(weight, room, is_whole)
        if (is_whole) then
            made = by_c(what + OF_DOUBLES, source, start, room, place(a), place(b), place(c), place(patch), place(weight))
            return
        end if
        made = 0
        do
            now = by_c(what + OF_DOUBLES, source, start + made, min(room - made, int(BLOCK, c_int64_t)), &
                place(part(:, 1), present(a)), place(part(:, 2), present(b)), place(part(:, 3), present(c)), &
                place(patches, present(patch)), place(part(:, 4), present(weight)))
            if (now <= 0) exit
            do k = 1, now
                if (present(a)) a(made + k) = part(k, 1)
                if (present(b)) b(made + k) = part(k, 2)
                if (present(c)) c(made + k) = part(k, 3)
                if (present(patch)) patch(made + k) = patches(k)
                if (present(weight)) weight(made + k) = part(k, 4)
            end do
            made = made + now
            if (made == room) exit
        end do
        if (now < 0) made = now
    end function

    integer(c_int64_t) function by_c(what, source, start, n, a, b, c, patch, weight) result(made)
        integer, intent(in) :: what
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: start, n
        type(c_ptr), intent(in) :: a, b, c, patch, weight
        select case (what)
        case (DIRECTIONS + OF_FLOATS)
            made = c_fill(source, start, n, a, b, c, patch, weight)
        case (DIRECTIONS + OF_DOUBLES)
            made = c_fill_double(source, start, n, a, b, c, patch, weight)
        case (NUMBERS + OF_FLOATS)
            made = c_numbers(source, start, n, a, b, c)
        case (NUMBERS + OF_DOUBLES)
            made = c_numbers_double(source, start, n, a, b, c)
        case (PLACES + OF_FLOATS)
            made = c_positions(source, start, n, a, b)
        case default
            made = c_positions_double(source, start, n, a, b)
        end select
    end function

    ! Make `room` no larger than a column, and tell whether the column is contiguous. One that is left out has no say.
    subroutine look(column, room, is_whole)
        type(*), intent(in), optional :: column(:)
        integer(c_int64_t), intent(inout) :: room
        logical, intent(inout) :: is_whole
        if (.not. present(column)) return
        room = min(room, size(column, kind=c_int64_t))
        is_whole = is_whole .and. is_contiguous(column)
    end subroutine

    ! Where a contiguous column begins; NULL where it is left out.
    type(c_ptr) function place(column, is_wanted)
        type(*), intent(in), optional, target :: column(:)
        logical, intent(in), optional :: is_wanted
        place = c_null_ptr
        if (present(column)) place = c_loc(column)
        if (present(is_wanted)) place = merge(place, c_null_ptr, is_wanted)
    end function

    ! Any integer in 64 bits. Another type is a mistake of the program, which a code would only hide.
    integer(c_int64_t) function whole(number)
        class(*), intent(in) :: number
        select type (number)
        type is (integer(c_int32_t))
            whole = number
        type is (integer(c_int64_t))
            whole = number
        class default
            error stop "aomc_sky: start, n, band and other counts are integers of 32 or 64 bits"
        end select
    end function

    ! Any integer in 32 bits. One that does not fit is -1, which no band, replicate or patch has: 2**32 is not band 0.
    integer(c_int32_t) function narrow(number)
        class(*), intent(in) :: number
        integer(c_int64_t) :: long
        long = whole(number)
        narrow = -1
        if (long >= 0 .and. long <= huge(narrow)) narrow = int(long, c_int32_t)
    end function
end module
