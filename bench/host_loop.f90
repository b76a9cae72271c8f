! The loop of a host in Fortran: batches of a band into the same arrays, and the directions added up.
function fortran_loop(next, context, n, batch, ux, uy, uz, adds) bind(c) result(total)
    use, intrinsic :: iso_c_binding
    use aomc_sky, only: sky_band, next_photons
    implicit none
    type(c_funptr), value :: next
    type(c_ptr), value :: context
    integer(c_int64_t), value :: n, batch
    integer(c_int), value :: adds
    real(c_float), intent(inout) :: ux(batch), uy(batch), uz(batch)
    real(c_double) :: total
    type(sky_band) :: band
    integer(c_int64_t) :: start, m, i
    band%next = next
    band%context = context
    total = 0
    do start = 0, n - 1, batch
        m = next_photons(band, start, ux, uy, uz)
        if (m <= 0) then
            total = 1
            return
        end if
        if (adds == 0) cycle
        do i = 1, m
            total = total + ux(i) + uy(i) + uz(i)
        end do
    end do
end function
