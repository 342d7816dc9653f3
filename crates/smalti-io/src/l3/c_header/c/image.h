
/* Renders an image with both stages: `out` holds X, Y and Z one after the other, each row by row. `work` holds
   @P@_WORK(raw->cols) numbers; what they are before does not matter. -1 when the image is too small. */
static inline int @p@_image(const @p@_raw *raw, @number@ *out, @number@ *work)
{
    const size_t plane = (size_t)raw->rows * (size_t)raw->cols;
    @p@_picture pictures[@P@_PICTURES], refined = { 0 };
    int32_t row, col, i, o;
    if (raw->rows < @P@_MIN_ROWS || raw->cols < @P@_MIN_COLS)
        return -1;
    for (i = 0; i < @P@_PICTURES; i++) {
        @p@_picture *p = &pictures[i];
        p->rows = @p@_halved[i] ? (raw->rows + 1) / 2 : raw->rows;
        p->cols = @p@_halved[i] ? (raw->cols + 1) / 2 : raw->cols;
        p->kept = @p@_kept[i];
        p->ready = 0;
        p->data = work;
        work += (size_t)3 * (size_t)p->kept * (size_t)p->cols;
    }
    refined.rows = raw->rows;
    refined.cols = raw->cols;
    refined.kept = 2 * @P@_CORRECTED_REACH + 1;
    refined.data = work;
    for (row = 0; row < raw->rows + @P@_CORRECTED_REACH; row++) {
        for (i = 0; row < raw->rows && i < @P@_PICTURES; i++) {
            @p@_picture *p = &pictures[i];
            const int32_t last = (@p@_halved[i] ? row / 2 : row) + @p@_beyond[i];
            for (; p->ready < p->rows && p->ready <= last; p->ready++)
                for (col = 0; col < p->cols; col++) {
                    @number@ pixel[3];
                    if (i == 0)
                        @p@_@pixel@(raw, p->ready, col, pixel);
                    else if (@p@_steps[i] == 0)
                        for (o = 0; o < 3; o++)
                            pixel[o] = @p@_at(p - 1, o, 2 * p->ready, 2 * col);
                    else
                        @p@_smooth(p - 1, p->ready, col, @p@_steps[i], @p@_squares[i], pixel);
                    for (o = 0; o < 3; o++)
                        @p@_line(p, o, p->ready)[col] = pixel[o];
                }
        }
        for (col = 0; row < raw->rows && col < raw->cols; col++) {
            @number@ pixel[3];
            @p@_refined_pixel(pictures, row, col, pixel);
            for (o = 0; o < 3; o++)
                @p@_line(&refined, o, row)[col] = pixel[o];
        }
        for (col = 0; row >= @P@_CORRECTED_REACH && col < raw->cols; col++) {
            const size_t at = (size_t)(row - @P@_CORRECTED_REACH) * (size_t)raw->cols + (size_t)col;
            @number@ pixel[3];
            @p@_corrected(raw, &refined, row - @P@_CORRECTED_REACH, col, pixel);
            for (o = 0; o < 3; o++)
                out[(size_t)o * plane + at] = pixel[o];
        }
    }
    return 0;
}
