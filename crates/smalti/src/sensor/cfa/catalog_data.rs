//! The entries of the catalogue. Patterns are facts of their publications; "as in isetL3" means that the pattern was
//! read from the table that Stanford's group published with its L³ work (`s_makeCFAs.m`), "as in forward_model" that it was read
//! from the software of Muller et al. (`misc/cfa_patterns.py`), not from the original.

use super::Modulation;
use super::catalog_entry::{CfaInfo, Layout};

type Filters = &'static [(char, &'static str)];

const RGB: Filters = &[('R', "red"), ('G', "green"), ('B', "blue")];
const RGBW: Filters = &[('R', "red"), ('G', "green"), ('B', "blue"), ('W', "white")];
const CYGM: Filters = &[('C', "cyan"), ('Y', "yellow"), ('G', "green"), ('M', "magenta")];
const RGBI: Filters =
    &[('R', "red+infrared"), ('G', "green+infrared"), ('B', "blue+infrared"), ('I', "infrared")];

const fn entry(
    name: &'static str,
    aliases: &'static [&'static str],
    lines: &'static [&'static str],
    filters: Filters,
    summary: &'static str,
    source: &'static str,
) -> CfaInfo {
    CfaInfo { name, aliases, summary, source, filters, layout: Layout::Letters(lines) }
}

/// The filters `band-k-of-n`.
macro_rules! bands {
    ($n:literal: $($letter:literal $k:literal),*) => {
        &[$(($letter, concat!("band-", $k, "-of-", $n))),*]
    };
}

const BAYER: &str = "[bayer1976] B. E. Bayer, Color imaging array, US 3,971,065 (1976).";
const LUKAC: &str = "[lukac2005] R. Lukac, K. N. Plataniotis, Color filter arrays: design and performance analysis, IEEE Trans. \
    Consum. Electron. 51(4), 1260 (2005); as in isetL3.";
const HIRAKAWA: &str = "[hirakawa2008] compared in K. Hirakawa, P. J. Wolfe, Spatio-spectral color filter array design for \
    optimal image recovery, IEEE Trans. Image Process. 17(10), 1876 (2008); as in isetL3.";
const KIJIMA: &str = "[kijima2007] T. Kijima, H. Nakamura, J. Compton, J. Hamilton, Image sensor with improved light \
    sensitivity, US 2007/0177236 (2007); [kumar2009] M. Kumar et al., ICIP 2009, 2681; as in isetL3.";
const YAMAGAMI: &str = "[yamagami1994] T. Yamagami, T. Sasaki, A. Suga, US 5,323,233 (1994); as in isetL3.";
const DCRAW: &str = "Arrangement as raw converters read it (dcraw's table of filter patterns, G M / Y C for the PowerShot Pro90 IS \
    and G1).";
const OWN: &str = "Arrangement of this library; arrangements of commercial snapshot sensors differ and could not be checked.";

/// Half a turn of the carrier apart per row, a third per column, with the largest amplitude within 0–1: the cosine
/// takes 0 and ±√3/2 there, so that the weights are 0, ½ and 1.
const CONDAT_AMPLITUDE: f64 = 0.577_350_269_189_625_8;
const QUARTER_ROOT_2: f64 = 0.353_553_390_593_273_8;

pub(super) static CATALOG: &[CfaInfo] = &[
    entry("bayer", &["rggb", "bayer-rggb"], &["RG", "GB"], RGB, "Bayer, red in the corner.", BAYER),
    entry("bayer-bggr", &["bggr"], &["BG", "GR"], RGB, "Bayer, blue in the corner.", BAYER),
    entry("bayer-grbg", &["grbg"], &["GR", "BG"], RGB, "Bayer, green in the corner, then red.", BAYER),
    entry("bayer-gbrg", &["gbrg"], &["GB", "RG"], RGB, "Bayer, green in the corner, then blue.", BAYER),
    entry(
        "quad-bayer",
        &["quad", "tetracell"],
        &["RRGG", "RRGG", "GGBB", "GGBB"],
        RGB,
        "Each cell of Bayer as 2 × 2 pixels, to be binned in low light.",
        "[sony2018] Sony Semiconductor Solutions, IMX586 (Quad Bayer array), press release of 23 July 2018.",
    ),
    entry(
        "nona-bayer",
        &["nona", "nonacell"],
        &["RRRGGG", "RRRGGG", "RRRGGG", "GGGBBB", "GGGBBB", "GGGBBB"],
        RGB,
        "Each cell of Bayer as 3 × 3 pixels.",
        "[samsung2020] Samsung, ISOCELL Bright HM1 (Nonacell), press release of 12 February 2020.",
    ),
    entry(
        "xtrans",
        &["x-trans", "fujifilm-x-trans"],
        &["GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG"],
        RGB,
        "Fujifilm's 6 × 6, every row and column with all three colours.",
        "[fujifilm2012] Fujifilm X-Pro1, X-Trans CMOS (2012); as in isetL3 and in raw converters' tables.",
    ),
    entry(
        "yamanaka",
        &[],
        &["GRGB", "GBGR"],
        RGB,
        "Green in every other column; red and blue alternate in the columns between.",
        "[yamanaka1977] S. Yamanaka, Solid state color camera, US 4,054,906 (1977); as in isetL3.",
    ),
    entry(
        "lukac",
        &["modified-bayer"],
        &["GR", "GB", "RG", "BG"],
        RGB,
        "Bayer with every other pair of rows shifted.",
        LUKAC,
    ),
    entry(
        "diagonal-bayer",
        &[],
        &["RGBG", "GRGB", "BGRG", "GBGR"],
        RGB,
        "Green checkerboard, red and blue on the diagonals between.",
        LUKAC,
    ),
    entry("stripe-vertical", &["stripes", "vertical-stripes"], &["RGB"], RGB, "Vertical stripes.", HIRAKAWA),
    entry(
        "stripe-horizontal",
        &["horizontal-stripes"],
        &["R", "G", "B"],
        RGB,
        "Horizontal stripes.",
        HIRAKAWA,
    ),
    entry(
        "stripe-diagonal",
        &["diagonal", "diagonal-stripes"],
        &["RGB", "BRG", "GBR"],
        RGB,
        "Diagonal stripes.",
        HIRAKAWA,
    ),
    entry(
        "rgbw",
        &["rgbw-2x2", "wrgb"],
        &["RG", "WB"],
        RGBW,
        "Bayer with one green replaced by white.",
        "[gindele2002] E. B. Gindele, A. C. Gallagher, US 6,476,865 (2002); [parmar2009] M. Parmar, B. A. Wandell, Interleaved \
         imaging, Proc. SPIE 7250, 725008 (2009); as in isetL3.",
    ),
    entry(
        "kodak",
        &["kodak2", "kodak-cfa2.0", "truesense", "rgbw-kodak"],
        &["WBWG", "BWGW", "WGWR", "GWRW"],
        RGBW,
        "Kodak CFA 2.0: half of the pixels white, colours paired along diagonals.",
        KIJIMA,
    ),
    entry(
        "kodak-b",
        &["rgbw-kodak-b"],
        &["GWRW", "GWRW", "BWGW", "BWGW"],
        RGBW,
        "Kodak, white columns, colours doubled down the column.",
        KIJIMA,
    ),
    entry(
        "kodak-c",
        &["rgbw-kodak-c"],
        &["GWRW", "BWGW"],
        RGBW,
        "Kodak, white columns, colours in Bayer's arrangement in the columns between.",
        KIJIMA,
    ),
    entry(
        "rgbw-hamilton",
        &["hamilton"],
        &["RWRWGWGW", "WRWRWGWG", "RWRWGWGW", "WRWRWGWG", "GWGWBWBW", "WGWGWBWB", "GWGWBWBW", "WGWGWBWB"],
        RGBW,
        "White checkerboard; the other cells are Bayer in blocks of 4 × 4 pixels.",
        "As in forward_model [muller2024], which gives a name only; presumably [hamilton2005] J. F. Hamilton, J. T. \
         Compton, Processing color and panchromatic pixels, US patent application 11/191,538 (2005), which could not be \
         read.",
    ),
    entry(
        "rgbw-sony",
        &["sony", "sony-rgbw"],
        &["WBWG", "RWGW", "WGWB", "GWRW"],
        RGBW,
        "Sony: white checkerboard, green on every other of the diagonals between.",
        "[sony2012] Sony, stacked CMOS image sensor with RGBW coding, press release 12-010E of 23 January 2012; as in isetL3.",
    ),
    entry(
        "rgbw-yamagami",
        &["yamagami"],
        &["WGWG", "RWBW", "WGWG", "BWRW"],
        RGBW,
        "White checkerboard; the other cells of a row are green, or alternate red and blue.",
        YAMAGAMI,
    ),
    entry(
        "rgbw-yamagami-b",
        &[],
        &["WGWRWB", "RWBWGW"],
        RGBW,
        "White checkerboard, with equal numbers of red, green and blue in the other cells.",
        YAMAGAMI,
    ),
    entry(
        "rgbw-susanu",
        &["susanu"],
        &["RWBWGW", "WBWGWR", "BWGWRW", "WGWRWB", "GWRWBW", "WRWBWG"],
        RGBW,
        "White checkerboard, red, green and blue on the diagonals between.",
        "[susanu2009] G. Susanu et al., RGBW sensor array, US 2009/0167893 (2009); as in isetL3.",
    ),
    entry(
        "wang2011",
        &["wang", "wang-5x5"],
        &["WRBWG", "WGWRB", "RBWGW", "GWRBW", "BWGWR"],
        RGBW,
        "5 × 5 with 40 % white, chrominance at (4π/5, 2π/5) and (2π/5, −4π/5).",
        "[wang2011] J. Wang, C. Zhang, P. Hao, New color filter arrays of high light sensitivity and high demosaicking \
         performance, ICIP 2011, 3153; as in isetL3, and its carriers are those the paper states.",
    ),
    entry(
        "chakrabarti2014",
        &["chakrabarti"],
        &["WWWWWW", "WWWWWW", "WWRGWW", "WWGBWW", "WWWWWW", "WWWWWW"],
        RGBW,
        "White with one 2 × 2 Bayer block in 6 × 6 pixels.",
        "[chakrabarti2014] A. Chakrabarti, W. T. Freeman, T. Zickler, Rethinking color cameras, ICCP 2014; as in isetL3 and \
         forward_model. The first author's later software has 4 × 4 pixels (chakrabarti2014-4x4).",
    ),
    entry(
        "chakrabarti2014-4x4",
        &["cfz14"],
        &["GBWW", "RGWW", "WWWW", "WWWW"],
        RGBW,
        "White with one 2 × 2 Bayer block in 4 × 4 pixels: the sparse pattern (CFZ) that chakrabarti2016 is compared with.",
        "[chakrabarti2014] as in the software of [chakrabarti2016] (CFZ14 in pylayers/sensor.py). isetL3 and forward_model \
         have 6 × 6 pixels for the same paper (chakrabarti2014); which of the two the paper has could not be checked.",
    ),
    entry(
        "chakrabarti2016",
        &["learncfa"],
        &["WGWWRWWW", "RWWWWWRW", "GWBBWBWW", "RBWWGWGB", "WWWWWGRW", "WRWGWWGR", "RWBWGWWW", "WGWWWWBB"],
        RGBW,
        "Learned together with a neural network that reconstructs the picture: 8 × 8 with 61 % white.",
        "[chakrabarti2016] A. Chakrabarti, Learning sensor multiplexing design through back-propagation, NIPS 2016, 3081; \
         as in its software (prototxt/flcfa50.prototxt).",
    ),
    entry(
        "rgbw-kaizu",
        &["kaizu"],
        &["RWGWBW", "WRWGWB", "GWBWRW", "WGWBWR", "BWRWGW", "WBWRWG"],
        RGBW,
        "White checkerboard; red, green and blue in turn along every row and column, paired along diagonals.",
        "[kaizu2017] Image processing apparatus, imaging device, image processing method, and program for reducing noise \
         or false colors in an image, US 9,699,429 (2017); as in forward_model [muller2024]. The tile meets the patent's \
         first claim.",
    ),
    entry(
        "rgbw-honda",
        &["honda"],
        &["WWWW", "WGWR", "WWWW", "WBWG"],
        RGBW,
        "Bayer at every second pixel of every second row, white between: 75 % white.",
        "As in forward_model [muller2024], which gives a name only; presumably [honda2009] H. Honda et al., A color CMOS \
         imager with 4 × 4 white-RGB color filter array for increased low-illumination signal-to-noise ratio, IEEE Trans. \
         Electron Devices (2009), which could not be read.",
    ),
    entry(
        "rgbw-sparse-3",
        &["sparse-3"],
        &["RWWWGWWW", "WWWWWWWW", "WWWWWWWW", "WWWWWWWW", "GWWWBWWW", "WWWWWWWW", "WWWWWWWW", "WWWWWWWW"],
        RGBW,
        "Bayer at every fourth pixel of every fourth row, three white pixels between: 94 % white.",
        "As sparse_3 in forward_model [muller2024], which names no publication.",
    ),
    entry(
        "rgbw-luo",
        &["luo"],
        &["WGWW", "RBRW", "WGWW", "WWWW"],
        RGBW,
        "A cross of two green, two red and one blue pixel in 4 × 4, otherwise white (69 %).",
        "[luo2007] G. Luo, Color filter array with neutral elements and color image formation, US 2007/0159542 (2007), \
         for the principle (clusters of colour among a majority of neutral elements); tile as in forward_model \
         [muller2024].",
    ),
    entry(
        "rgbw-quad",
        &["quad-rgbw", "rgbw-binning"],
        &["GGRR", "GGRR", "BBWW", "BBWW"],
        RGBW,
        "Each cell of rgbw as 2 × 2 pixels, to be binned in low light.",
        "As binning in forward_model [muller2024], which names no publication.",
    ),
    entry(
        "rgbw-random",
        &["random-rgbw"],
        &["WWWWWWWW", "WBWGWBWR", "WWWWWWWW", "WRWRWBWG", "WWWWWWWW", "WBWGWGWR", "WWWWWWWW", "WRWBWBWG"],
        RGBW,
        "One pixel of every 2 × 2 is red, green or blue at random, the others are white.",
        "As random in forward_model [muller2024], which names no publication; [oh2017] P. Oh, S. Lee, M. G. Kang, \
         Colorization-based RGB-white color interpolation using color filter array with randomly sampled pattern, \
         Sensors 17(7), 1523 (2017), for the principle.",
    ),
    entry(
        "rccb",
        &["clarity+", "aptina-clarity", "rwbw"],
        &["RC", "CB"],
        &[('R', "red"), ('C', "clear"), ('B', "blue")],
        "Aptina Clarity+: Bayer with clear in place of green.",
        "[aptina] Aptina's Clarity+ solution, an Aptina technology white paper; as in isetL3.",
    ),
    entry(
        "rccc",
        &[],
        &["RC", "CC"],
        &[('R', "red"), ('C', "clear")],
        "Three clear pixels and a red one, for driver assistance.",
        "Common in automotive sensors (Aptina/onsemi AR0132AT); stated by makers as three clear and one red, without a paper.",
    ),
    entry(
        "ryyb",
        &["huawei-ryyb"],
        &["RY", "YB"],
        &[('R', "red"), ('Y', "yellow"), ('B', "blue")],
        "Bayer with yellow in place of green.",
        "[huawei2019] Huawei P30 Pro, SuperSpectrum sensor (IMX650), announcement of 26 March 2019.",
    ),
    entry(
        "cyym",
        &["kodak-cyym"],
        &["CY", "YM"],
        &[('C', "cyan"), ('Y', "yellow"), ('M', "magenta")],
        "Bayer's arrangement in complementary colours, yellow in place of green.",
        "Kodak DCS 620x and 720x; arrangement as raw converters read it (dcraw: colours M Y C Y).",
    ),
    entry("cygm", &["gmyc", "cmyg"], &["GM", "YC"], CYGM, "Complementary colours and green.", DCRAW),
    entry(
        "cygm-interlaced",
        &["gmcymgcy"],
        &["GM", "CY", "MG", "CY"],
        CYGM,
        "Complementary colours and green for field readout: sums of two rows give luminance and chrominance.",
        "[sato1983] I. Sato et al., Color image pick-up apparatus, US 4,390,895 (1983), for the principle; arrangement as raw \
         converters read it (dcraw, Canon PowerShot 600).",
    ),
    entry(
        "rgbe",
        &["sony-rgbe", "rgeb"],
        &["RE", "GB"],
        &[('R', "red"), ('G', "green"), ('B', "blue"), ('E', "emerald")],
        "Bayer with one green replaced by emerald.",
        "[sony2003] Sony press release 03-029E of 15 July 2003 (DSC-F828); as in isetL3 and dcraw.",
    ),
    entry(
        "rgbcmy",
        &["rgbcmy-3x2"],
        &["RC", "BY", "GM"],
        &[('R', "red"), ('G', "green"), ('B', "blue"), ('C', "cyan"), ('M', "magenta"), ('Y', "yellow")],
        "Six colours in 3 × 2.",
        "[lansel2011] S. Lansel, B. Wandell, Local linear learned image processing pipeline, Imaging Systems and Applications 2011, \
         IMC3; as in isetL3.",
    ),
    entry(
        "cmy",
        &["cmy-sajadi"],
        &["CMY", "MYC"],
        &[('C', "cyan"), ('M', "magenta"), ('Y', "yellow")],
        "Complementary colours only, 2 × 3.",
        "[sajadi2011] B. Sajadi et al., Switchable primaries using shiftable layers of color filter arrays, SIGGRAPH 2011; as in \
         isetL3.",
    ),
    entry(
        "rgbir",
        &["rgb-ir", "rgbir-2x2"],
        &["BG", "IR"],
        RGBI,
        "Bayer with the green beside red replaced by near infrared.",
        "OmniVision OV4682 (RGB-Ir); described so by e-con Systems (the green next to red is infrared).",
    ),
    entry(
        "rgbir-4x4",
        &["rgb-ir-4x4"],
        &["BGRG", "GIGI", "RGBG", "GIGI"],
        RGBI,
        "Half of the pixels green, an eighth red, an eighth blue, a quarter near infrared.",
        "OmniVision OV4686; read from public driver code, no paper.",
    ),
    entry(
        "rgbx",
        &["rgbn", "medical"],
        &["RG", "XB"],
        &[('R', "red"), ('G', "green"), ('B', "blue"), ('X', "narrow")],
        "Bayer with one green replaced by a narrow band, as for medical imaging.",
        "Arrangement as in isetL3 (Bayer with one green replaced with narrow band); the band is this library's.",
    ),
    entry(
        "five-band",
        &["monno", "monno5"],
        &["RGOG", "GCGB", "OGRG", "GBGC"],
        &[
            ('R', "five-band/R"),
            ('O', "five-band/O"),
            ('G', "five-band/G"),
            ('C', "five-band/C"),
            ('B', "five-band/B"),
        ],
        "Half of the pixels green; red, orange, cyan and blue an eighth each.",
        "[monno2012] Y. Monno, M. Tanaka, M. Okutomi, Multispectral demosaicking using guided filter, Proc. SPIE 8299, 82990O \
         (2012); as in isetL3.",
    ),
    entry(
        "multispectral-3x3",
        &["ms9", "multispectral-9"],
        &["AFH", "EGC", "IBD"],
        bands!(9: 'A' 1, 'B' 2, 'C' 3, 'D' 4, 'E' 5, 'F' 6, 'G' 7, 'H' 8, 'I' 9),
        "Nine bands; every row and column has one of each third of the spectrum.",
        OWN,
    ),
    entry(
        "multispectral-4x4",
        &["ms16", "multispectral-16", "binary-tree-16"],
        &["AICK", "MEOG", "DLBJ", "PHNF"],
        bands!(
            16: 'A' 1, 'B' 2, 'C' 3, 'D' 4, 'E' 5, 'F' 6, 'G' 7, 'H' 8, 'I' 9, 'J' 10, 'K' 11, 'L' 12, 'M' 13,
            'N' 14, 'O' 15, 'P' 16
        ),
        "Sixteen bands, checkerboards split into checkerboards.",
        "[miao2006] L. Miao, H. Qi, The design and evaluation of a generic method for generating mosaicked multispectral filter \
         arrays, IEEE Trans. Image Process. 15(9), 2780 (2006), for the method (binary tree, equal probabilities); which band \
         goes to which leaf is this library's.",
    ),
    entry(
        "multispectral-5x5",
        &["ms25", "multispectral-25"],
        &["ALWIT", "HSEKV", "OUGRD", "QCNYF", "XJPBM"],
        bands!(
            25: 'A' 1, 'B' 2, 'C' 3, 'D' 4, 'E' 5, 'F' 6, 'G' 7, 'H' 8, 'I' 9, 'J' 10, 'K' 11, 'L' 12, 'M' 13,
            'N' 14, 'O' 15, 'P' 16, 'Q' 17, 'R' 18, 'S' 19, 'T' 20, 'U' 21, 'V' 22, 'W' 23, 'X' 24, 'Y' 25
        ),
        "Twenty-five bands; every row and column has one of each fifth of the spectrum.",
        OWN,
    ),
    CfaInfo {
        name: "hirakawa2008",
        aliases: &["hirakawa-wolfe", "hirakawa"],
        summary: "Chrominance at the carrier (π, π/2): red and blue in quadrature, green opposite to their sum; 2 × 4 cells.",
        source: "[hirakawa2008] K. Hirakawa, P. J. Wolfe, Spatio-spectral color filter array design for optimal image recovery, IEEE \
                 Trans. Image Process. 17(10), 1876 (2008), for the principle; weights computed here from the carrier, as the \
                 paper's tables could not be checked.",
        filters: RGB,
        layout: Layout::Weighted {
            rows: 2,
            cols: 4,
            carrier: [1.0, 1.0],
            primaries: &[
                Modulation { mean: 0.5, amplitude: QUARTER_ROOT_2, phase_turns: -0.125 },
                Modulation { mean: 0.5, amplitude: 0.5, phase_turns: 0.5 },
                Modulation { mean: 0.5, amplitude: QUARTER_ROOT_2, phase_turns: 0.125 },
            ],
        },
    },
    CfaInfo {
        name: "condat2011",
        aliases: &["condat"],
        summary: "Chrominance at the carrier (π, 2π/3): red, green and blue a third of a turn apart at full amplitude; 2 × 3 cells.",
        source: "[condat2011] L. Condat, A new color filter array with optimal properties for noiseless and noisy color image \
                 acquisition, IEEE Trans. Image Process. 20(8), 2200 (2011); cells computed from that description (2 × 3, largest \
                 amplitude within 0–1), their choice of origin and colour order may differ.",
        filters: RGB,
        layout: Layout::Weighted {
            rows: 2,
            cols: 3,
            carrier: [1.0, 1.0],
            primaries: &[
                Modulation { mean: 0.5, amplitude: CONDAT_AMPLITUDE, phase_turns: -0.25 },
                Modulation { mean: 0.5, amplitude: CONDAT_AMPLITUDE, phase_turns: -0.25 + 1.0 / 3.0 },
                Modulation { mean: 0.5, amplitude: CONDAT_AMPLITUDE, phase_turns: -0.25 - 1.0 / 3.0 },
            ],
        },
    },
    CfaInfo {
        name: "random",
        aliases: &["blue-noise"],
        summary: "Random with blue noise: random?channels=3&rows=8&cols=8&seed=1 (each optional).",
        source: "[condat2010] L. Condat, Color filter array design using random patterns with blue noise chromatic spectra, Image Vis. \
                 Comput. 28(8), 1196 (2010), for the aim; [ulichney1993] R. Ulichney, The void-and-cluster method for dither array \
                 generation, Proc. SPIE 1913, 332 (1993), for the energy. The tiles are this library's.",
        filters: RGB,
        layout: Layout::Random,
    },
    entry(
        "mono",
        &["monochrome"],
        &["W"],
        &[('W', "white")],
        "No colour filter.",
        "A sensor without a colour filter array.",
    ),
];
