
/* A raw image. Its first sample sees cell (phase_row, phase_col) of the tile. */
typedef struct {
    const uint16_t *samples;
    int32_t rows, cols;           /* at least @P@_MIN_ROWS x @P@_MIN_COLS */
    int32_t stride;               /* samples from one row to the next */
    int32_t phase_row, phase_col; /* 0 or more */
} @p@_raw;

static inline int32_t @p@_modulo(int32_t a, int32_t n)
{
    const int32_t m = a % n;
    return m < 0 ? m + n : m;
}

/* The place in 0..len-1 that stands in for `at`: itself; beyond the ends the one of the same phase in a tile of `period`
   that is nearest to the place mirrored about the outermost sample. */
static inline int32_t @p@_place(int32_t at, int32_t len, int32_t period)
{
    int32_t mirror = 0, low, high;
    if (at >= 0 && at < len)
        return at;
    if (len > 1) {
        mirror = @p@_modulo(at, 2 * (len - 1));
        if (mirror >= len)
            mirror = 2 * (len - 1) - mirror;
    }
    low = mirror - @p@_modulo(mirror - at, period);
    high = low + period;
    if (low >= 0 && (high >= len || mirror - low <= high - mirror))
        return low;
    return high < len ? high : mirror;
}

static inline int32_t @p@_sample(const @p@_raw *raw, int32_t row, int32_t col)
{
    const int32_t r = @p@_place(row, raw->rows, @P@_TILE_ROWS), c = @p@_place(col, raw->cols, @P@_TILE_COLS);
    return raw->samples[(size_t)r * (size_t)raw->stride + (size_t)c];
}

/* The cell of the tile that a pixel, or one beyond the border, sees. */
static inline int32_t @p@_position(const @p@_raw *raw, int32_t row, int32_t col)
{
    return @p@_modulo(row + raw->phase_row, @P@_TILE_ROWS) * @P@_TILE_COLS
         + @p@_modulo(col + raw->phase_col, @P@_TILE_COLS);
}

static inline int32_t @p@_bits(uint32_t x)
{
    int32_t n = 0;
    for (; x != 0; x &= x - 1)
        n++;
    return n;
}

/* The place on the saturation axis of a combination of clipped channels: of those that differ in the fewest channels the
   one with most channels clipped. A table of 2^channels entries does the same. */
static inline int32_t @p@_saturation(uint32_t clipped)
{
    int32_t best = 0, i;
    for (i = 1; i < @P@_SATURATIONS && clipped != 0; i++) {
        const int32_t here = @p@_bits(@p@_saturation_masks[i] ^ clipped);
        const int32_t there = @p@_bits(@p@_saturation_masks[best] ^ clipped);
        if (here < there
            || (here == there && @p@_bits(@p@_saturation_masks[i]) > @p@_bits(@p@_saturation_masks[best])))
            best = i;
    }
    return best;
}
