
/* A sample, 0 at the black level and 1 at the white level. */
static inline float @p@_value(const @p@_raw *raw, int32_t row, int32_t col)
{
    return ((float)@p@_sample(raw, row, col) - @P@_BLACK) * @P@_GAIN;
}

#if @P@_TEXTURES > 1
static inline float @p@_magnitude(float v)
{
    return v < 0.0f ? -v : v;
}
#endif

#if @P@_TEXTURES > 2
/* 1 to 4 for an edge across which the image changes along 0, 45, 90, 135 degrees (from right to down), 0 for none. */
static inline int32_t @p@_edge(const @p@_raw *raw, int32_t row, int32_t col)
{
    float down2 = 0.0f, both = 0.0f, right2 = 0.0f, difference, twice, all;
    int32_t r, c;
    for (c = -@P@_HALF; c <= @P@_HALF; c++) {
        float column[3] = { 0.0f, 0.0f, 0.0f };
        for (r = -@P@_HALF; r <= @P@_HALF; r++) {
            float along[2], down, right;
            int32_t i;
            for (i = 0; i < 2; i++) {
                const int16_t *e = @p@_edge_ends[i];
                along[i] = @p@_value(raw, row + r + e[2], col + c + e[3])
                         - @p@_value(raw, row + r + e[0], col + c + e[1]);
            }
            down = @p@_edge_gradient[0][0] * along[0] + @p@_edge_gradient[0][1] * along[1];
            right = @p@_edge_gradient[1][0] * along[0] + @p@_edge_gradient[1][1] * along[1];
            column[0] += down * down;
            column[1] += down * right;
            column[2] += right * right;
        }
        down2 += column[0];
        both += column[1];
        right2 += column[2];
    }
    difference = right2 - down2;
    twice = 2.0f * both;
    all = 0.5f * (down2 + right2);
    if (!(difference * difference + twice * twice > all * all))
        return 0;
    if (@p@_magnitude(difference) >= @p@_magnitude(twice))
        return difference >= 0.0f ? 1 : 3;
    return twice > 0.0f ? 2 : 4;
}
#endif

/* The index of the class of a pixel. Sums run down the columns of the patch, and then along the row. */
static inline uint32_t @p@_class(const @p@_raw *raw, int32_t row, int32_t col)
{
    const int32_t position = @p@_position(raw, row, col);
    int32_t level = 0, texture = 0, r, c;
    uint32_t clipped = 0;
#if @P@_LEVELS > 1 || @P@_TEXTURES > 1
    float mean = 0.0f;
#endif
    for (c = -@P@_HALF; c <= @P@_HALF; c++) {
#if @P@_LEVELS > 1 || @P@_TEXTURES > 1
        float column = 0.0f;
#endif
        for (r = -@P@_HALF; r <= @P@_HALF; r++) {
            const float v = @p@_value(raw, row + r, col + c);
#if @P@_LEVELS > 1 || @P@_TEXTURES > 1
            column += v;
#endif
            if (v >= @P@_CLIP)
                clipped |= (uint32_t)1 << @p@_tile[@p@_position(raw, row + r, col + c)];
        }
#if @P@_LEVELS > 1 || @P@_TEXTURES > 1
        mean += column;
#endif
    }
#if @P@_LEVELS > 1 || @P@_TEXTURES > 1
    mean *= 1.0f / @P@_TAPS;
#endif
#if @P@_LEVELS > 1
    for (c = 0; c < @P@_LEVELS - 1; c++)
        level += mean >= @p@_cuts[position % @P@_CUT_SETS][c];
#endif
#if @P@_TEXTURES > 1
    {
        const float light = mean > 0.0f ? mean : 0.0f;
        float contrast = 0.0f;
        int32_t i;
        for (i = 0; i < 2; i++) {
            const int16_t *p = @p@_pairs[i];
            for (c = p[4]; c <= p[5]; c++) {
                float column = 0.0f;
                for (r = p[2]; r <= p[3]; r++)
                    column += @p@_magnitude(@p@_value(raw, row + r, col + c)
                                            - @p@_value(raw, row + r + p[0], col + c + p[1]));
                contrast += column;
            }
        }
        texture = contrast * contrast > @P@_FLAT_0 + (@P@_FLAT_1 + @P@_FLAT_2 * light) * light;
    }
#endif
#if @P@_TEXTURES > 2
    if (texture)
        texture += @p@_edge(raw, row, col);
#endif
    return (uint32_t)(((position * @P@_SATURATIONS + @p@_saturation(clipped)) * @P@_LEVELS + level) * @P@_TEXTURES
                      + texture);
}

/* Sixteen sums in the order of the library, which vectors of pixels share. */
static inline float @p@_tree(const float p[16])
{
    float four[4];
    int32_t i;
    for (i = 0; i < 4; i++)
        four[i] = (p[4 * i] + p[4 * i + 2]) + (p[4 * i + 1] + p[4 * i + 3]);
    return (four[0] + four[1]) + (four[2] + four[3]);
}

/* The outputs of a pixel. */
static inline void @p@_pixel(const @p@_raw *raw, int32_t row, int32_t col, float out[@P@_OUTPUTS])
{
    const uint32_t class_index = @p@_class(raw, row, col);
    float patch[@P@_TAPS + 1];
    int32_t o, r, c, i;
    for (c = 0; c < @P@_SIDE; c++)
        for (r = 0; r < @P@_SIDE; r++)
            patch[c * @P@_SIDE + r] = @p@_value(raw, row + r - @P@_HALF, col + c - @P@_HALF);
    patch[@P@_TAPS] = 1.0f;
    for (o = 0; o < @P@_OUTPUTS; o++) {
        const float *k = @p@_kernels[class_index][o];
        float sums[16] = { 0.0f };
        for (i = 0; i <= @P@_TAPS; i++)
            sums[i % 16] = i < 16 ? patch[i] * k[i] : sums[i % 16] + patch[i] * k[i];
        out[o] = @p@_tree(sums);
    }
}

/* Renders an image@of@: `out` holds the outputs one after the other, each row by row. -1 when the image is too small. */
static inline int @p@_@first@(const @p@_raw *raw, float *out)
{
    const size_t plane = (size_t)raw->rows * (size_t)raw->cols;
    int32_t row, col, o;
    float pixel[@P@_OUTPUTS];
    if (raw->rows < @P@_MIN_ROWS || raw->cols < @P@_MIN_COLS)
        return -1;
    for (row = 0; row < raw->rows; row++)
        for (col = 0; col < raw->cols; col++) {
            @p@_pixel(raw, row, col, pixel);
            for (o = 0; o < @P@_OUTPUTS; o++)
                out[(size_t)o * plane + (size_t)row * (size_t)raw->cols + (size_t)col] = pixel[o];
        }
    return 0;
}
