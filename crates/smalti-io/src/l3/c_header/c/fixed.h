
#if @P@_TEXTURES > 2
/* 1 to 4 for an edge across which the image changes along 0, 45, 90, 135 degrees (from right to down), 0 for none. */
static inline int32_t @p@_edge(const @p@_raw *raw, int32_t row, int32_t col)
{
    int64_t down2 = 0, both = 0, right2 = 0, difference, twice, all;
    int32_t r, c;
    for (r = -@P@_HALF; r <= @P@_HALF; r++)
        for (c = -@P@_HALF; c <= @P@_HALF; c++) {
            int64_t along[2], down, right;
            int32_t i;
            for (i = 0; i < 2; i++) {
                const int16_t *e = @p@_edge_ends[i];
                along[i] = @p@_sample(raw, row + r + e[2], col + c + e[3])
                         - @p@_sample(raw, row + r + e[0], col + c + e[1]);
            }
            down = @p@_edge_gradient[0][0] * along[0] + @p@_edge_gradient[0][1] * along[1];
            right = @p@_edge_gradient[1][0] * along[0] + @p@_edge_gradient[1][1] * along[1];
            down2 += down * down;
            both += down * right;
            right2 += right * right;
        }
    difference = right2 - down2;
    twice = 2 * both;
    all = right2 + down2;
    /* |difference| and |twice| are at most `all`; what follows squares it. */
    while (all >= (int64_t)1 << 30) {
        difference /= 2;
        twice /= 2;
        all /= 2;
    }
    /* (difference, twice) is as long as the difference of the tensor's eigenvalues: at least half their sum is asked for. */
    if (4 * (difference * difference + twice * twice) <= all * all)
        return 0;
    if ((difference < 0 ? -difference : difference) >= (twice < 0 ? -twice : twice))
        return difference >= 0 ? 1 : 3;
    return twice > 0 ? 2 : 4;
}
#endif

/* The index of the class of a pixel. */
static inline uint32_t @p@_class(const @p@_raw *raw, int32_t row, int32_t col)
{
    const int32_t position = @p@_position(raw, row, col);
    uint32_t sum = 0, clipped = 0;
    int32_t level = 0, texture = 0, r, c;
    for (r = -@P@_HALF; r <= @P@_HALF; r++)
        for (c = -@P@_HALF; c <= @P@_HALF; c++) {
            const uint32_t v = (uint32_t)@p@_sample(raw, row + r, col + c);
            sum += v;
            if (v >= @P@_CLIP)
                clipped |= (uint32_t)1 << @p@_tile[@p@_position(raw, row + r, col + c)];
        }
#if @P@_LEVELS > 1
    for (c = 0; c < @P@_LEVELS - 1; c++)
        level += sum >= @p@_cuts[position % @P@_CUT_SETS][c];
#endif
#if @P@_TEXTURES > 1
    {
        const uint64_t light = sum > @P@_BLACK_SUM ? sum - @P@_BLACK_SUM : 0;
        uint64_t contrast = 0, flat;
        int32_t i;
        for (i = 0; i < 2; i++) {
            const int16_t *p = @p@_pairs[i];
            for (r = p[2]; r <= p[3]; r++)
                for (c = p[4]; c <= p[5]; c++) {
                    const int32_t d = @p@_sample(raw, row + r, col + c)
                                    - @p@_sample(raw, row + r + p[0], col + c + p[1]);
                    contrast += (uint64_t)(d < 0 ? -d : d);
                }
        }
        flat = @P@_FLAT_0 + light * (@P@_FLAT_1 + ((light * @P@_FLAT_2) >> @P@_FLAT_2_BITS));
        texture = ((contrast * contrast) << @P@_FLAT_BITS) > flat;
    }
#endif
#if @P@_TEXTURES > 2
    if (texture)
        texture += @p@_edge(raw, row, col);
#endif
    return (uint32_t)(((position * @P@_SATURATIONS + @p@_saturation(clipped)) * @P@_LEVELS + level) * @P@_TEXTURES
                      + texture);
}

/* A sample as kernels take it: less black, rounded down by SAMPLE_SHIFT bits (halves up), of 16 bits. */
static inline int32_t @p@_reduced(int32_t sample)
{
    int32_t d = sample - @P@_BLACK;
#if @P@_SAMPLE_SHIFT > 0
    /* What is shifted is not negative. */
    d = ((d + 65536 + 1) >> 1) - 32768;
#endif
    return d > 32767 ? 32767 : d < -32768 ? -32768 : d;
}

/* The sums of a pixel, and their binary places, which are returned: @P@_SCALE * sum / 2^places are its outputs. No sum
   overflows, whatever the samples. */
static inline int32_t @p@_pixel(const @p@_raw *raw, int32_t row, int32_t col, int32_t out[@P@_OUTPUTS])
{
    const uint32_t class_index = @p@_class(raw, row, col);
    int32_t o, r, c;
    for (o = 0; o < @P@_OUTPUTS; o++) {
        const int16_t *k = @p@_kernels[class_index][o];
        int32_t sum = @p@_offsets[class_index][o];
        for (r = -@P@_HALF; r <= @P@_HALF; r++)
            for (c = -@P@_HALF; c <= @P@_HALF; c++)
                sum += *k++ * @p@_reduced(@p@_sample(raw, row + r, col + c));
        out[o] = sum;
    }
    return @p@_shifts[class_index];
}

/* Renders an image@of@: `out` holds the sums of the outputs one after the other, each row by row, `places` the binary places of
   each pixel. -1 when the image is too small. Where one scale is to hold for all pixels, shift sums right by
   places - @P@_MIN_SHIFT, with halves up: they have @P@_MIN_SHIFT places then. */
static inline int @p@_@first@(const @p@_raw *raw, int32_t *out, uint8_t *places)
{
    const size_t plane = (size_t)raw->rows * (size_t)raw->cols;
    int32_t row, col, o, pixel[@P@_OUTPUTS];
    if (raw->rows < @P@_MIN_ROWS || raw->cols < @P@_MIN_COLS)
        return -1;
    for (row = 0; row < raw->rows; row++)
        for (col = 0; col < raw->cols; col++) {
            const size_t at = (size_t)row * (size_t)raw->cols + (size_t)col;
            places[at] = (uint8_t)@p@_pixel(raw, row, col, pixel);
            for (o = 0; o < @P@_OUTPUTS; o++)
                out[(size_t)o * plane + at] = pixel[o];
        }
    return 0;
}
