
/* A pixel of a smooth picture: the mean over 3 x 3 pixels `step` apart, with binomial weights times (most - d)^2, where d is
   the squared difference of the colours. Neighbours whose difference is above `most` do not count. */
static inline void @p@_smooth(const @p@_picture *from, int32_t row, int32_t col, int32_t step,
                             const float squares[3], float out[3])
{
    /* Down, right, times, in the order of summation. */
    static const int8_t around[8][3] = { { -1, 0, 2 }, { 0, -1, 2 }, { 0, 1, 2 }, { 1, 0, 2 },
                                         { -1, -1, 1 }, { -1, 1, 1 }, { 1, -1, 1 }, { 1, 1, 1 } };
    float own[3], sums[3], light, square, most, total;
    int32_t i, plane;
    for (plane = 0; plane < 3; plane++)
        own[plane] = @p@_at(from, plane, row, col);
    light = own[1] > 0.0f ? own[1] : 0.0f;
    square = squares[0] + (squares[1] + squares[2] * light) * light;
    square = square > 1e-15f ? square : 1e-15f;
    most = 2.0f * (square < 1e15f ? square : 1e15f);
    total = 4.0f * most * most;
    for (plane = 0; plane < 3; plane++)
        sums[plane] = total * own[plane];
    for (i = 0; i < 8; i++) {
        float other[3], x, y, z, left, weight;
        for (plane = 0; plane < 3; plane++)
            other[plane] = @p@_at(from, plane, row + around[i][0] * step, col + around[i][1] * step);
        x = other[0] - own[0];
        y = other[1] - own[1];
        z = other[2] - own[2];
        y *= y;
        left = most - (x * x + z * z + (y + y));
        left = left > 0.0f ? left : 0.0f;
        weight = (float)around[i][2] * left * left;
        total += weight;
        for (plane = 0; plane < 3; plane++)
            sums[plane] += weight * other[plane];
    }
    total = 1.0f / total;
    for (plane = 0; plane < 3; plane++)
        out[plane] = sums[plane] * total;
}

/* The class of a pixel: level and structure, by Y of the finest smooth picture. */
static inline uint32_t @p@_refined_class(const @p@_picture *p, int32_t row, int32_t col)
{
    static const float tent[5] = { 1.0f / 9.0f, 2.0f / 9.0f, 3.0f / 9.0f, 2.0f / 9.0f, 1.0f / 9.0f };
    float tensor[3] = { 0.0f, 0.0f, 0.0f }, lines[3], mean, light, noise, trace, difference, twice;
    int32_t level = 0, strength = 0, kind = 0, i, r, c;
    for (c = -2; c <= 2; c++) {
        float column[3] = { 0.0f, 0.0f, 0.0f };
        for (r = -2; r <= 2; r++) {
            const float across = 0.5f * (@p@_at(p, 1, row + r, col + c + 1) - @p@_at(p, 1, row + r, col + c - 1));
            const float down = 0.5f * (@p@_at(p, 1, row + r + 1, col + c) - @p@_at(p, 1, row + r - 1, col + c));
            column[0] += tent[r + 2] * (across * across);
            column[1] += tent[r + 2] * (down * down);
            column[2] += tent[r + 2] * (across * down);
        }
        for (i = 0; i < 3; i++)
            tensor[i] += tent[c + 2] * column[i];
    }
    for (i = 0; i < 3; i++)
        lines[i] = @p@_at(p, 1, row + i - 1, col - 1) + 2.0f * @p@_at(p, 1, row + i - 1, col)
                + @p@_at(p, 1, row + i - 1, col + 1);
    mean = (lines[0] + 2.0f * lines[1] + lines[2]) / 16.0f;
    light = mean > 0.0f ? mean : 0.0f;
    noise = @P@_NOISE_0 + (@P@_NOISE_1 + @P@_NOISE_2 * light) * light;
#if @P@_REFINED_LEVELS > 1
    for (i = 0; i < @P@_REFINED_LEVELS - 1; i++)
        level += @p@_refined_cuts[i] <= mean;
#endif
    trace = tensor[0] + tensor[1];
    difference = tensor[0] - tensor[1];
    twice = 2.0f * tensor[2];
    for (i = 0; i < @P@_STRENGTHS; i++)
        strength += trace > @p@_strengths[i] * noise;
    if (strength == 0)
        return (uint32_t)(level * @P@_STRUCTURES);
    if (difference * difference + twice * twice > 0.25f * trace * trace) {
        const float along = difference < 0.0f ? -difference : difference, across = twice < 0.0f ? -twice : twice;
#if @P@_ORIENTATIONS == 8
        /* The tangent of 22.5 degrees. */
        const float tangent = @P@_TANGENT;
        const int32_t from_axis = (across > tangent * along) + (tangent * across >= along);
        const int32_t turned = difference >= 0.0f ? from_axis : 4 - from_axis;
        kind = 1 + (twice > 0.0f ? turned : (8 - turned) % 8);
#else
        kind = 1 + (along >= across ? (difference >= 0.0f ? 0 : 2) : (twice > 0.0f ? 1 : 3));
#endif
    }
    return (uint32_t)(level * @P@_STRUCTURES + 1 + (strength - 1) * (1 + @P@_ORIENTATIONS) + kind);
}

/* Square roots of products of red, green and blue of ITU-R BT.2020. Negative channels count as 0. */
static inline void @p@_roots(const @p@_picture *p, int32_t row, int32_t col, float out[3])
{
    float rgb[3];
    int32_t i;
    for (i = 0; i < 3; i++) {
        rgb[i] = @p@_rgb_from_xyz[i][0] * @p@_at(p, 0, row, col) + @p@_rgb_from_xyz[i][1] * @p@_at(p, 1, row, col)
               + @p@_rgb_from_xyz[i][2] * @p@_at(p, 2, row, col);
        rgb[i] = rgb[i] > 0.0f ? rgb[i] : 0.0f;
    }
    for (i = 0; i < 3; i++)
        out[i] = sqrtf(rgb[i] * rgb[(i + 1) % 3]);
}

/* The outputs of a pixel of the second stage, from all pictures. */
static inline void @p@_refined_pixel(const @p@_picture pictures[@P@_PICTURES], int32_t row, int32_t col, float out[3])
{
    const uint32_t class_index = @p@_refined_class(&pictures[1], row, col);
    float inputs[@P@_LANES] = { 0.0f };
    int32_t at = 0, scale, plane, o, r, c, i;
    for (c = -2; c <= 2; c++)
        for (r = -2; r <= 2; r++)
            inputs[at++] = @p@_at(&pictures[0], 1, row + r, col + c);
    for (c = -1; c <= 1; c++)
        for (plane = 0; plane <= 2; plane += 2)
            for (r = -1; r <= 1; r++)
                inputs[at++] = @p@_at(&pictures[0], plane, row + r, col + c);
    @p@_roots(&pictures[3], row, col, inputs + at);
    at = @P@_LANES - 16;
    for (scale = 0; scale < 5; scale++)
        for (plane = 0; plane < 3; plane++)
            inputs[at++] = scale < 3 ? @p@_at(&pictures[1 + scale], plane, row, col)
                                     : @p@_at(&pictures[2 + scale], plane, row / 2, col / 2);
    inputs[at] = 1.0f;
    for (o = 0; o < 3; o++) {
        const float *k = @p@_refined_kernels[class_index][o];
        float sums[16] = { 0.0f };
        for (i = 0; i < @P@_LANES; i++)
            sums[i % 16] = i < 16 ? inputs[i] * k[i] : sums[i % 16] + inputs[i] * k[i];
        out[o] = @p@_tree(sums);
    }
}

/* A mean of nine numbers with binomial weights. */
static inline float @p@_weighted(const float v[9])
{
    return v[4] * (70.0f / 256.0f) + (v[3] + v[5]) * (56.0f / 256.0f) + (v[2] + v[6]) * (28.0f / 256.0f)
         + (v[1] + v[7]) * (8.0f / 256.0f) + (v[0] + v[8]) * (1.0f / 256.0f);
}

/* The Y that the sample of a pixel gives, from Y and responses of the samples around it that see the same cell of the tile:
   at least half of `light` and at most twice as much. It is `light` where the sample is clipped or the tile has more than
   four rows and columns. */
static inline float @p@_given(const @p@_raw *raw, const @p@_picture *p, int32_t row, int32_t col, float light)
{
    const int32_t down = 4 / @P@_TILE_ROWS * @P@_TILE_ROWS, right = 4 / @P@_TILE_COLS * @P@_TILE_COLS;
    float own = -1.0f, lights = 0.0f, responses = 0.0f, given;
    int32_t r, c;
    if (@P@_TILE_ROWS > 4 && @P@_TILE_COLS > 4)
        return light;
    for (c = col - right; c <= col + right; c += @P@_TILE_COLS) {
        float of_column[2] = { 0.0f, 0.0f };
        for (r = row - down; r <= row + down; r += @P@_TILE_ROWS) {
            float response, y, weight;
            if (r < 0 || r >= raw->rows || c < 0 || c >= raw->cols)
                continue;
            response = @p@_value(raw, r, c);
            if (!(response < @P@_CLIP))
                continue;
            response = response > 0.0f ? response : 0.0f;
            if (r == row && c == col)
                own = response;
            y = @p@_light(p, r, c);
            weight = 1.0f / (y + response + @P@_DARK);
            of_column[0] += weight * y;
            of_column[1] += weight * response;
        }
        lights += of_column[0];
        responses += of_column[1];
    }
    if (!(own >= 0.0f && responses > 0.0f))
        return light;
    given = own * lights / responses;
    given = given > 2.0f * light ? 2.0f * light : given;
    return given < 0.5f * light ? 0.5f * light : given;
}

/* A pixel of the refined picture. Beside light that is many times as bright it has the mean colour of the light around it,
   in which light near saturation counts less and X and Z are at most 3 and 16 times Y. Its Y goes halfway to the one that its
   own sample gives, and is at least half of the mean Y of its neighbours and a quarter of the mean Y around it. */
static inline void @p@_corrected(const @p@_raw *raw, const @p@_picture *p, int32_t row, int32_t col, float out[3])
{
    /* Weights of light in the contrast, by distance. The Y of dark pixels is divided by them. */
    static const float falls[5] = { 1.0f, 1.0f, 1.0f, 0.5f, 0.25f };
    float brightest = 0.0f, darkest = 0.0f, sums[4] = { 0.0f }, lines[9], columns[9], around, nearby, least, light, share, factor;
    int32_t r, c, plane;
    for (r = -4; r <= 4; r++)
        for (c = -4; c <= 4; c++) {
            const int32_t down = r < 0 ? -r : r, right = c < 0 ? -c : c;
            const float fall = falls[down] * falls[right];
            const float y = @p@_light(p, row + r, col + c), lit = y * fall, dark = (y + @P@_DARK) / fall;
            brightest = lit > brightest ? lit : brightest;
            darkest = (r == -4 && c == -4) || dark < darkest ? dark : darkest;
        }
    share = (brightest / darkest - 16.0f) / 16.0f;
    for (plane = 0; plane < 3; plane++)
        out[plane] = @p@_at(p, plane, row, col);
    if (!(share > 0.0f))
        return;
    share = share < 1.0f ? share : 1.0f;
    for (c = -4; c <= 4; c++) {
        float of_column[4] = { 0.0f, 0.0f, 0.0f, 0.0f };
        for (r = -4; r <= 4; r++) {
            float own[3], headroom = 0.0f;
            for (plane = 0; plane < 3; plane++) {
                own[plane] = @p@_at(p, plane, row + r, col + c);
                headroom = own[plane] > headroom ? own[plane] : headroom;
            }
            headroom = 1.0f - headroom > 0.25f ? 1.0f - headroom : 0.25f;
            headroom *= headroom;
            headroom *= headroom;
            for (plane = 0; plane < 3; plane++)
                of_column[plane] += headroom * own[plane];
            of_column[3] += headroom;
            lines[r + 4] = @p@_light(p, row + r, col + c);
        }
        columns[c + 4] = @p@_weighted(lines);
        for (plane = 0; plane < 4; plane++)
            sums[plane] += of_column[plane];
    }
    around = @p@_weighted(columns);
    for (c = -1; c <= 1; c++)
        columns[c + 1] = (@p@_light(p, row - 1, col + c) + @p@_light(p, row + 1, col + c)
                          + 2.0f * @p@_light(p, row, col + c)) * 0.25f;
    nearby = (columns[0] + columns[2] + 2.0f * columns[1]) * 0.25f;
    least = 0.25f * around > 0.5f * nearby ? 0.25f * around : 0.5f * nearby;
    light = out[1] > least ? out[1] : least;
    light = 0.5f * (light + @p@_given(raw, p, row, col, light));
    light = light > least ? light : least;
    factor = sums[1] < @P@_DARK * sums[3] ? @P@_DARK * sums[3] : sums[1];
    factor = sums[0] * (1.0f / 3.0f) > factor ? sums[0] * (1.0f / 3.0f) : factor;
    factor = sums[2] * (1.0f / 16.0f) > factor ? sums[2] * (1.0f / 16.0f) : factor;
    factor = light / factor;
    for (plane = 0; plane < 3; plane++) {
        const float goal = plane == 1 ? light : (sums[plane] < 0.0f ? 0.0f : sums[plane]) * factor;
        out[plane] += share * (goal - out[plane]);
    }
}
