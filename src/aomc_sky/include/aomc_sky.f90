! The photons of aomc-sky from a file, without Python: Fortran 2008 over aomc_sky.h, whose comments say what each function
! does. Compile aomc_sky.c with the program. MIT licence.
!
!    type(aomc_sky_file) :: file
!    type(aomc_sky_source) :: source
!    code = aomc_sky_load("day.sky", file)
!    if (code == 0) code = aomc_sky_band(file, 0, source)
!    if (code /= 0) print *, aomc_sky_message(int(code, int64))
!    n = aomc_sky_fill(source, start, ux, uy, uz)
!
! Bands and photons count from 0, as in C: the first photon of the first band is photon 0 of band 0.
module aomc_sky
    use, intrinsic :: iso_c_binding
    implicit none
    private

    type, bind(c), public :: aomc_sky_file
        type(c_ptr) :: bytes = c_null_ptr
        integer(c_int64_t) :: size = 0
        integer(c_int32_t) :: n_bands = 0, precision = 0
        character(kind=c_char) :: plan_sha256(65) = c_null_char
        character(kind=c_char) :: is_owned = c_null_char, reserve(6) = c_null_char
    end type

    type, bind(c), public :: aomc_sky_source
        integer(c_int64_t) :: n = 0 ! photons
        real(c_double) :: wavelength_nm = 0, irradiance_w_m2_nm = 0
        integer(c_int64_t) :: ours(54) = 0
    end type

    type, bind(c), public :: aomc_sky_photon
        real(c_float) :: ux, uy, uz
        integer(c_int32_t) :: patch
    end type

    type, bind(c), public :: aomc_sky_photon_double
        real(c_double) :: ux, uy, uz
        integer(c_int32_t) :: patch
    end type

    ! Directions of the photons from `start` on, as many as the arrays hold; how many, 0 at the end, negative: a code.
    interface aomc_sky_fill
        module procedure fill_single, fill_double
    end interface

    ! Their numbers, of which the second and the third may be left out.
    interface aomc_sky_numbers
        module procedure numbers_single, numbers_double
    end interface

    public :: aomc_sky_load, aomc_sky_view, aomc_sky_unload, aomc_sky_band, aomc_sky_at, aomc_sky_at_double
    public :: aomc_sky_fill, aomc_sky_numbers, aomc_sky_witness, aomc_sky_message

    interface
        function view_c(bytes, size, file) bind(c, name="aomc_sky_view") result(code)
            import :: c_int, c_int64_t, c_ptr, aomc_sky_file
            type(c_ptr), value :: bytes
            integer(c_int64_t), value :: size
            type(aomc_sky_file), intent(out) :: file
            integer(c_int) :: code
        end function

        function load_c(path, file) bind(c, name="aomc_sky_load") result(code)
            import :: c_char, c_int, aomc_sky_file
            character(kind=c_char), intent(in) :: path(*)
            type(aomc_sky_file), intent(out) :: file
            integer(c_int) :: code
        end function

        subroutine aomc_sky_unload(file) bind(c)
            import :: aomc_sky_file
            type(aomc_sky_file), intent(inout) :: file
        end subroutine

        function aomc_sky_band(file, band, source) bind(c) result(code)
            import :: c_int, c_int32_t, aomc_sky_file, aomc_sky_source
            type(aomc_sky_file), intent(in) :: file
            integer(c_int32_t), value :: band
            type(aomc_sky_source), intent(out) :: source
            integer(c_int) :: code
        end function

        function aomc_sky_witness(source) bind(c) result(code)
            import :: c_int, aomc_sky_source
            type(aomc_sky_source), intent(in) :: source
            integer(c_int) :: code
        end function

        function aomc_sky_at(source, i) bind(c) result(photon)
            import :: c_int64_t, aomc_sky_source, aomc_sky_photon
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            type(aomc_sky_photon) :: photon
        end function

        function aomc_sky_at_double(source, i) bind(c) result(photon)
            import :: c_int64_t, aomc_sky_source, aomc_sky_photon_double
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: i
            type(aomc_sky_photon_double) :: photon
        end function

        function fill_c(source, start, n, ux, uy, uz) bind(c, name="aomc_sky_fill") result(done)
            import :: c_float, c_int64_t, aomc_sky_source
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_float), intent(inout) :: ux(*), uy(*), uz(*)
            integer(c_int64_t) :: done
        end function

        function fill_double_c(source, start, n, ux, uy, uz) bind(c, name="aomc_sky_fill_double") result(done)
            import :: c_double, c_int64_t, aomc_sky_source
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_double), intent(inout) :: ux(*), uy(*), uz(*)
            integer(c_int64_t) :: done
        end function

        function numbers_c(source, start, n, n1, n2, n3) bind(c, name="aomc_sky_numbers") result(done)
            import :: c_float, c_int64_t, aomc_sky_source
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_float), intent(inout), optional :: n1(*), n2(*), n3(*)
            integer(c_int64_t) :: done
        end function

        function numbers_double_c(source, start, n, n1, n2, n3) bind(c, name="aomc_sky_numbers_double") result(done)
            import :: c_double, c_int64_t, aomc_sky_source
            type(aomc_sky_source), intent(in) :: source
            integer(c_int64_t), value :: start, n
            real(c_double), intent(inout), optional :: n1(*), n2(*), n3(*)
            integer(c_int64_t) :: done
        end function

        function message_c(code) bind(c, name="aomc_sky_message") result(text)
            import :: c_int64_t, c_ptr
            integer(c_int64_t), value :: code
            type(c_ptr) :: text
        end function

        pure function strlen(text) bind(c) result(n)
            import :: c_ptr, c_size_t
            type(c_ptr), value, intent(in) :: text
            integer(c_size_t) :: n
        end function
    end interface

contains

    function aomc_sky_load(path, file) result(code)
        character(*), intent(in) :: path
        type(aomc_sky_file), intent(out) :: file
        integer(c_int) :: code
        code = load_c(trim(path) // c_null_char, file)
    end function

    ! The bytes of a file in memory, which must begin at a multiple of 16, as allocated arrays do, and stay there.
    function aomc_sky_view(bytes, file) result(code)
        character(kind=c_char), intent(in), target, contiguous :: bytes(:)
        type(aomc_sky_file), intent(out) :: file
        integer(c_int) :: code
        code = view_c(c_loc(bytes), size(bytes, kind=c_int64_t), file)
    end function

    function fill_single(source, start, ux, uy, uz) result(n)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: start
        real(c_float), intent(inout), contiguous :: ux(:), uy(:), uz(:)
        integer(c_int64_t) :: n
        n = fill_c(source, start, int(min(size(ux), size(uy), size(uz)), c_int64_t), ux, uy, uz)
    end function

    function fill_double(source, start, ux, uy, uz) result(n)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: start
        real(c_double), intent(inout), contiguous :: ux(:), uy(:), uz(:)
        integer(c_int64_t) :: n
        n = fill_double_c(source, start, int(min(size(ux), size(uy), size(uz)), c_int64_t), ux, uy, uz)
    end function

    function numbers_single(source, start, n1, n2, n3) result(n)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: start
        real(c_float), intent(inout), contiguous :: n1(:)
        real(c_float), intent(inout), contiguous, optional :: n2(:), n3(:)
        integer(c_int64_t) :: n
        n = size(n1)
        if (present(n2)) n = min(n, size(n2, kind=c_int64_t))
        if (present(n3)) n = min(n, size(n3, kind=c_int64_t))
        n = numbers_c(source, start, n, n1, n2, n3)
    end function

    function numbers_double(source, start, n1, n2, n3) result(n)
        type(aomc_sky_source), intent(in) :: source
        integer(c_int64_t), intent(in) :: start
        real(c_double), intent(inout), contiguous :: n1(:)
        real(c_double), intent(inout), contiguous, optional :: n2(:), n3(:)
        integer(c_int64_t) :: n
        n = size(n1)
        if (present(n2)) n = min(n, size(n2, kind=c_int64_t))
        if (present(n3)) n = min(n, size(n3, kind=c_int64_t))
        n = numbers_double_c(source, start, n, n1, n2, n3)
    end function

    ! What a code says.
    function aomc_sky_message(code) result(text)
        integer(c_int64_t), intent(in) :: code
        character(:), allocatable :: text
        character(kind=c_char), pointer :: letters(:)
        type(c_ptr) :: address
        integer :: i
        address = message_c(code)
        call c_f_pointer(address, letters, [strlen(address)])
        allocate (character(size(letters)) :: text)
        do i = 1, size(letters)
            text(i:i) = letters(i)
        end do
    end function
end module
