! The weight of a patch as the AOMC program writes it, bit patterns for zenith 1 to 90 and three radiances.
program aomc_weight
  implicit none
  real, parameter :: pi = 3.14159265
  real :: radiance(3), theta, ring, w
  integer :: z, k
  radiance = (/ 1.0, 0.1, 12345.678 /)
  do z = 1, 90
    theta = z * pi / 180.0
    ring = 0.01745329
    if (z == 1 .or. z == 89) ring = 0.0261799
    do k = 1, 3
      w = radiance(k) * sin(theta) * ring * 0.01745329 * cos(theta)
      print '(i0)', transfer(w, z)
    end do
  end do
end program aomc_weight
