! What gfortran makes of amc.inp: a list of paths on standard input, one line of results for each.
! Plain twin of aomc_sky.formats.aomc.amc; reals are read with 64 bits and printed as their bit pattern.
program read_amc
  use iso_fortran_env, only: int64, real64, input_unit
  implicit none
  integer, parameter :: n_max = 31
  ! widths of the integers; 0 marks F12.2, -1 F12.4, -2 F12.6
  integer, parameter :: kinds(30) = [12, 1, 8, 8, 8, 0, 0, 8, -1, 8, 8, 1, 1, 1, 1, 1, 8, 8, 8, -2, 1, 1, &
                                     -2, -2, -2, 1, -2, -2, 1, 8]
  character(len=1024) :: path
  integer :: status
  do
     read (input_unit, '(A)', iostat=status) path
     if (status /= 0) exit
     call read_one(trim(path(3:)), path(1:1) == 'P')
  end do
contains
  subroutine read_one(name, polar_cap)
    character(len=*), intent(in) :: name
    logical, intent(in) :: polar_cap
    integer :: unit, status, i, k, n, kinds_here(n_max)
    integer(int64) :: whole, bits(n_max)
    real(real64) :: number
    n = merge(31, 30, polar_cap)
    if (polar_cap) then
       kinds_here = [kinds(1:11), 1, kinds(12:30)]
    else
       kinds_here(1:30) = kinds
    end if
    open (newunit=unit, file=name, status='old', action='read')
    status = 0
    do i = 1, n
       k = kinds_here(i)
       if (k == 12) read (unit, '(48X,I12)', iostat=status) whole
       if (k == 8) read (unit, '(48X,I8)', iostat=status) whole
       if (k == 1) read (unit, '(48X,I1)', iostat=status) whole
       if (k == 0) read (unit, '(48X,F12.2)', iostat=status) number
       if (k == -1) read (unit, '(48X,F12.4)', iostat=status) number
       if (k == -2) read (unit, '(48X,F12.6)', iostat=status) number
       if (status /= 0) exit
       if (k > 0) bits(i) = whole
       if (k <= 0) bits(i) = transfer(number, bits(i))
    end do
    close (unit)
    if (status /= 0) then
       print '(A,I0)', 'error ', i
    else
       print '(A,*(1X,I0))', 'ok', bits(1:n)
    end if
  end subroutine read_one
end program read_amc
