! What AOMC's main program does around its subroutine `light`, written anew: its modules, the file of its own light
! source, its loops, and its bins of single precision that end at 2 pi; no water. Compile it with -fcheck=bounds.
!   aomc_stub LSOURCE N_BANDS TITER FILE
! TITER: photons of each waveband. FILE gets theta and phi of every photon, then, for every number of azimuth bins from
! 1 to 360, the photons above the surface and those behind it, all wavebands together.
module propagation_global
    implicit none
    real :: theta, phi
end module

module const_global
    implicit none
    integer :: lambda
end module

module light_global
    implicit none
    integer :: lsource
    real, allocatable :: intensity(:)
    integer, allocatable, dimension(:, :, :) :: sky_nint
end module

module bins
    implicit none
    real, parameter :: pi = 3.14159265
    integer, parameter :: alphaint = 90, most = 360
    type :: log_of_photons
        integer, allocatable :: n(:, :) ! azimuth bin, layer
    end type
    type(log_of_photons) :: logs(most)
    integer :: polar(alphaint) = 0
contains
    subroutine make_bins()
        integer :: phiint
        do phiint = 1, most
            allocate (logs(phiint)%n(phiint, -1:0), source=0)
        end do
    end subroutine

    ! As AOMC logs a photon at a layer: there is no bin for phi = 2 pi.
    subroutine log_photon(theta, phi, layer)
        real, intent(in) :: theta, phi
        integer, intent(in) :: layer
        real :: nalpha, nphi
        integer :: phiint, t, p
        nalpha = pi / real(alphaint)
        t = int(theta / nalpha) + 1
        polar(t) = polar(t) + 1
        do phiint = 1, most
            nphi = 2 * pi / real(phiint)
            p = int(phi / nphi) + 1
            logs(phiint)%n(p, layer) = logs(phiint)%n(p, layer) + 1
        end do
    end subroutine

    ! The surface turns the azimuth by pi; the program takes what is within 0.0001 of 2 pi as 0.
    function turned(phi)
        real, intent(in) :: phi
        real :: turned
        turned = phi + pi
        if (turned > 2 * pi) turned = turned - 2 * pi
        if (abs(turned - 2 * pi) < 0.0001) turned = 0.0
    end function
end module

program aomc_stub
    use bins
    use propagation_global
    use const_global
    use light_global
    implicit none
    integer :: titer, lam, photon, control, unit, phiint
    character(300) :: word
    call get_command_argument(1, word)
    read (word, *) lsource
    call get_command_argument(2, word)
    read (word, *) lambda
    allocate (intensity(lambda))
    call get_command_argument(3, word)
    read (word, *) titer
    call get_command_argument(4, word)
    open (newunit=unit, file=trim(word), access="stream", form="unformatted", status="replace")
    if (lsource == 0) call read_difcol()
    allocate (sky_nint(1, 2, 0:2))
    sky_nint = titer / 2
    sky_nint(1, 2, 1:2) = titer
    call make_bins()
    control = -77 ! the program sets it for tables only
    do lam = 1, lambda
        if (lsource == 1) control = 1
        do photon = 1, titer
            call light(1, lam, photon, control)
            write (unit) theta, phi
            call log_photon(theta, phi, -1)
            call log_photon(theta, turned(phi), 0)
        end do
    end do
    do phiint = 1, most
        write (unit) logs(phiint)%n
    end do

contains

    ! The program reads difcol.inp before any photon, whatever `light` does, and goes no further without it.
    subroutine read_difcol()
        integer :: difcol, status, records, k
        real :: direct
        open (newunit=difcol, file="difcol.inp", status="old", iostat=status)
        if (status /= 0) error stop "Failed to open 'difcol.inp'"
        read (difcol, *) records
        if (records /= lambda) error stop "Number of records in 'difcol.inp' do not match number of wavelengths."
        do k = 1, lambda
            read (difcol, *) direct, intensity(k)
        end do
        close (difcol)
    end subroutine
end program
