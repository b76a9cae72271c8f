! The photons of aomc-sky in a Fortran program; Fortran 2008, the same functions as aomc_sky_embed.h.
!
! Link a program that starts Python itself with aomc_sky_embed.c. Bands and photons count from 0, as in C: the first
! photon of the first band is photon 0 of band 0. Directions are unit vectors of travel with z up: uz <= 0.
! `next_photons` needs no lock. Any number of threads may call it at once.
!
!    type(sky_scene) :: scene
!    type(sky_band) :: band
!    call open_scene("amc.inp", 1_int64, scene, status)
!    call get_band(scene, 0_int64, band, status)
!    n = next_photons(band, start, ux, uy, uz)
module aomc_sky_embed
    use, intrinsic :: iso_c_binding
    implicit none
    private

    integer(c_int64_t), parameter, public :: sky_closed = -1, sky_bad_start = -2, sky_bad_count = -3, sky_no_array = -4

    ! A scene that is open; close it with close_scene.
    type, public :: sky_scene
        type(c_ptr) :: handle = c_null_ptr
    end type

    ! aomc_sky_source of the header.
    type, bind(c), public :: sky_band
        type(c_funptr) :: next = c_null_funptr
        type(c_funptr) :: next_double = c_null_funptr
        type(c_ptr) :: context = c_null_ptr
        integer(c_int64_t) :: n_photons = 0
        real(c_double) :: wavelength_nm = 0
        type(c_funptr) :: numbers = c_null_funptr
        type(c_funptr) :: numbers_double = c_null_funptr
    end type

    ! Write the directions of the photons from `start` on and return the number of photons: fewer than the arrays
    ! hold at the end of the band, then 0. A negative answer is an error.
    interface next_photons
        module procedure next_single, next_double
    end interface

    ! Write up to three numbers in [0, 1) of each photon from `start` on. The answers are those of next_photons. The
    ! numbers are further coordinates of the low-discrepancy point of the photon, for its first free path, its first
    ! scattering angle and the azimuth of that scattering. The second and the third may be left out.
    interface next_numbers
        module procedure numbers_single, numbers_double
    end interface

    public :: open_scene, open_run, close_scene, n_bands, get_band, next_photons, next_numbers, error_text

    abstract interface
        function next_single_c(context, start, n, ux, uy, uz) bind(c)
            import :: c_ptr, c_int64_t, c_float
            type(c_ptr), value :: context
            integer(c_int64_t), value :: start, n
            real(c_float), intent(inout) :: ux(*), uy(*), uz(*)
            integer(c_int64_t) :: next_single_c
        end function

        function next_double_c(context, start, n, ux, uy, uz) bind(c)
            import :: c_ptr, c_int64_t, c_double
            type(c_ptr), value :: context
            integer(c_int64_t), value :: start, n
            real(c_double), intent(inout) :: ux(*), uy(*), uz(*)
            integer(c_int64_t) :: next_double_c
        end function
        function numbers_single_c(context, start, n, n1, n2, n3) bind(c)
            import :: c_ptr, c_int64_t, c_float
            type(c_ptr), value :: context
            integer(c_int64_t), value :: start, n
            real(c_float), intent(inout), optional :: n1(*), n2(*), n3(*)
            integer(c_int64_t) :: numbers_single_c
        end function

        function numbers_double_c(context, start, n, n1, n2, n3) bind(c)
            import :: c_ptr, c_int64_t, c_double
            type(c_ptr), value :: context
            integer(c_int64_t), value :: start, n
            real(c_double), intent(inout), optional :: n1(*), n2(*), n3(*)
            integer(c_int64_t) :: numbers_double_c
        end function
    end interface

    interface
        function aomc_sky_open(path, seed, options, scene) bind(c)
            import :: c_char, c_int64_t, c_ptr, c_int
            character(kind=c_char), intent(in) :: path(*), options(*)
            integer(c_int64_t), value :: seed
            type(c_ptr), intent(out) :: scene
            integer(c_int) :: aomc_sky_open
        end function

        function aomc_sky_open_run(folder, scene) bind(c)
            import :: c_char, c_ptr, c_int
            character(kind=c_char), intent(in) :: folder(*)
            type(c_ptr), intent(out) :: scene
            integer(c_int) :: aomc_sky_open_run
        end function

        function aomc_sky_bands(scene) bind(c)
            import :: c_ptr, c_int64_t
            type(c_ptr), value :: scene
            integer(c_int64_t) :: aomc_sky_bands
        end function

        function aomc_sky_band(scene, band, source) bind(c)
            import :: c_ptr, c_int64_t, c_int, sky_band
            type(c_ptr), value :: scene
            integer(c_int64_t), value :: band
            type(sky_band), intent(out) :: source
            integer(c_int) :: aomc_sky_band
        end function

        subroutine aomc_sky_close(scene) bind(c)
            import :: c_ptr
            type(c_ptr), value :: scene
        end subroutine

        function aomc_sky_error() bind(c)
            import :: c_ptr
            type(c_ptr) :: aomc_sky_error
        end function

        function c_strlen(text) bind(c, name="strlen")
            import :: c_ptr, c_size_t
            type(c_ptr), value :: text
            integer(c_size_t) :: c_strlen
        end function
    end interface

contains

    ! Open amc.inp or the folder of a scene; status is 0, or -1 with the reason in error_text().
    ! The 64 bits of `seed` count as unsigned; `options` are words name=value, see aomc_sky_embed.h.
    subroutine open_scene(path, seed, scene, status, options)
        character(*), intent(in) :: path
        integer(c_int64_t), intent(in) :: seed
        type(sky_scene), intent(out) :: scene
        integer, intent(out) :: status
        character(*), intent(in), optional :: options
        if (present(options)) then
            status = aomc_sky_open(c_text(path), seed, c_text(options), scene%handle)
        else
            status = aomc_sky_open(c_text(path), seed, c_text(""), scene%handle)
        end if
    end subroutine

    ! Open a run folder: the photons of its plan.
    subroutine open_run(folder, scene, status)
        character(*), intent(in) :: folder
        type(sky_scene), intent(out) :: scene
        integer, intent(out) :: status
        status = aomc_sky_open_run(c_text(folder), scene%handle)
    end subroutine

    ! Close a scene; its bands answer sky_closed from now on.
    subroutine close_scene(scene)
        type(sky_scene), intent(inout) :: scene
        call aomc_sky_close(scene%handle)
        scene%handle = c_null_ptr
    end subroutine

    ! Number of bands of a scene.
    function n_bands(scene)
        type(sky_scene), intent(in) :: scene
        integer(c_int64_t) :: n_bands
        n_bands = aomc_sky_bands(scene%handle)
    end function

    ! The photons of one band, 0 to n_bands - 1; status is 0, or -1 with the reason in error_text().
    subroutine get_band(scene, band, found, status)
        type(sky_scene), intent(in) :: scene
        integer(c_int64_t), intent(in) :: band
        type(sky_band), intent(out) :: found
        integer, intent(out) :: status
        status = aomc_sky_band(scene%handle, band, found)
    end subroutine

    function next_single(band, start, ux, uy, uz) result(n)
        type(sky_band), intent(in) :: band
        integer(c_int64_t), intent(in) :: start
        real(c_float), intent(inout), contiguous :: ux(:), uy(:), uz(:)
        integer(c_int64_t) :: n
        procedure(next_single_c), pointer :: next
        n = sky_closed
        if (.not. c_associated(band%next)) return
        call c_f_procpointer(band%next, next)
        n = next(band%context, start, room(size(ux), size(uy), size(uz)), ux, uy, uz)
    end function

    function next_double(band, start, ux, uy, uz) result(n)
        type(sky_band), intent(in) :: band
        integer(c_int64_t), intent(in) :: start
        real(c_double), intent(inout), contiguous :: ux(:), uy(:), uz(:)
        integer(c_int64_t) :: n
        procedure(next_double_c), pointer :: next
        n = sky_closed
        if (.not. c_associated(band%next_double)) return
        call c_f_procpointer(band%next_double, next)
        n = next(band%context, start, room(size(ux), size(uy), size(uz)), ux, uy, uz)
    end function

    function numbers_single(band, start, n1, n2, n3) result(n)
        type(sky_band), intent(in) :: band
        integer(c_int64_t), intent(in) :: start
        real(c_float), intent(inout), contiguous :: n1(:)
        real(c_float), intent(inout), contiguous, optional :: n2(:), n3(:)
        integer(c_int64_t) :: n, wanted
        procedure(numbers_single_c), pointer :: numbers
        n = sky_closed
        if (.not. c_associated(band%numbers)) return
        call c_f_procpointer(band%numbers, numbers)
        wanted = size(n1, kind=c_int64_t)
        if (present(n2)) wanted = min(wanted, size(n2, kind=c_int64_t))
        if (present(n3)) wanted = min(wanted, size(n3, kind=c_int64_t))
        n = numbers(band%context, start, wanted, n1, n2, n3)
    end function

    function numbers_double(band, start, n1, n2, n3) result(n)
        type(sky_band), intent(in) :: band
        integer(c_int64_t), intent(in) :: start
        real(c_double), intent(inout), contiguous :: n1(:)
        real(c_double), intent(inout), contiguous, optional :: n2(:), n3(:)
        integer(c_int64_t) :: n, wanted
        procedure(numbers_double_c), pointer :: numbers
        n = sky_closed
        if (.not. c_associated(band%numbers_double)) return
        call c_f_procpointer(band%numbers_double, numbers)
        wanted = size(n1, kind=c_int64_t)
        if (present(n2)) wanted = min(wanted, size(n2, kind=c_int64_t))
        if (present(n3)) wanted = min(wanted, size(n3, kind=c_int64_t))
        n = numbers(band%context, start, wanted, n1, n2, n3)
    end function

    ! Photons that all three arrays can hold.
    pure function room(nx, ny, nz)
        integer, intent(in) :: nx, ny, nz
        integer(c_int64_t) :: room
        room = min(nx, ny, nz)
    end function

    ! The reason for the last failure.
    function error_text() result(text)
        character(:), allocatable :: text
        character(kind=c_char), pointer :: letters(:)
        type(c_ptr) :: address
        integer :: i
        address = aomc_sky_error()
        call c_f_pointer(address, letters, [c_strlen(address)])
        allocate (character(size(letters)) :: text)
        do i = 1, size(letters)
            text(i:i) = letters(i)
        end do
    end function

    pure function c_text(text) result(letters)
        character(*), intent(in) :: text
        character(kind=c_char) :: letters(len_trim(text) + 1)
        integer :: i
        do i = 1, len_trim(text)
            letters(i) = text(i:i)
        end do
        letters(len_trim(text) + 1) = c_null_char
    end function
end module
